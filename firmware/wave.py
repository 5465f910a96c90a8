"""Writes `rwbed/wave.h`, one period of the multisine: `python firmware/wave.py`."""

from pathlib import Path

import numpy as np

SAMPLES = 256
TONES = (1, 3, 5, 8, 13, 21)  # harmonics of the period, equally strong
TARGET = Path(__file__).parent / "rwbed" / "wave.h"


def samples() -> np.ndarray:
    """One period, -127 to 127; phases by Schroeder (IEEE Trans. Inf. Theory 16, 1970), which keep the peak low."""
    n = np.arange(SAMPLES)
    phases = [-np.pi * k * (k + 1) / len(TONES) for k in range(len(TONES))]
    wave = sum(np.sin(2 * np.pi * tone * n / SAMPLES + phase) for tone, phase in zip(TONES, phases, strict=True))
    return np.rint(127 * wave / np.max(np.abs(wave))).astype(int)


def text() -> str:
    """The header file."""
    wave = samples()
    rows = [",".join(f"{v:4d}" for v in wave[k : k + 16]) for k in range(0, SAMPLES, 16)]
    table = ",\n".join(f"    {row}" for row in rows)
    return f"""/* One period of the multisine: harmonics {", ".join(map(str, TONES))}. Written by firmware/wave.py. */
#ifndef WAVE_H
#define WAVE_H

#include <stdint.h>

#ifdef __AVR__
#include <avr/pgmspace.h>
#else
#define PROGMEM
#define pgm_read_byte(address) (*(const uint8_t *)(address))
#endif

static const int8_t wave[{SAMPLES}] PROGMEM = {{
{table}}};

static inline int8_t wave_sample(uint8_t k) {{ return (int8_t)pgm_read_byte(&wave[k]); }}

#endif
"""


if __name__ == "__main__":
    TARGET.write_text(text())
