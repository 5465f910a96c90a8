"""Writes `rwbed/wave.h`, one period of the multisine: `python firmware/wave.py`."""

from pathlib import Path

from rwjax.planning.experiment import TONES, WAVE_SAMPLES, wave

TARGET = Path(__file__).parent / "rwbed" / "wave.h"


def text() -> str:
    """The header file."""
    rows = [",".join(f"{v:4d}" for v in wave()[k : k + 16]) for k in range(0, WAVE_SAMPLES, 16)]
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

static const int8_t wave[{WAVE_SAMPLES}] PROGMEM = {{
{table}}};

static inline int8_t wave_sample(uint8_t k) {{ return (int8_t)pgm_read_byte(&wave[k]); }}

#endif
"""


if __name__ == "__main__":
    TARGET.write_text(text())
