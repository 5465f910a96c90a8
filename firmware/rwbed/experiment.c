#include "experiment.h"

#include "wave.h"

static int32_t unit(const struct experiment *e, uint32_t tick) { /* -127 ... 127 */
    uint32_t phase = tick % e->period;
    uint16_t half = e->period / 2;
    switch (e->kind) {
    case COAST_DOWN:
        return tick < e->period ? 127 : 0;
    case SQUARE:
        return phase < half ? 127 : -127;
    case TRIANGLE: { /* from 0 up to 127, down to -127, back to 0 */
        uint32_t turned = (4 * phase) / e->period;
        int32_t slope = (int32_t)(508UL * phase / e->period);
        return turned == 0 ? slope : turned < 3 ? 254 - slope : slope - 508;
    }
    case STAIRCASE: { /* up in STAIRS steps and down again, all of them equally long */
        uint32_t step = (2UL * STAIRS * phase) / e->period;
        if (step > STAIRS)
            step = 2UL * STAIRS - step;
        return -127 + (int32_t)(254 * step / STAIRS);
    }
    default:
        return wave_sample((uint8_t)(WAVE_SAMPLES * phase / e->period));
    }
}

uint8_t experiment_over(const struct experiment *e, uint32_t tick) { return tick >= REST_TICKS + e->length; }

int16_t experiment_width(const struct experiment *e, uint32_t tick) {
    if (tick < REST_TICKS || experiment_over(e, tick))
        return 0;
    tick -= REST_TICKS;
    if (e->kind == COAST_DOWN && tick >= e->period)
        return 0;
    return (int16_t)(e->offset + e->amplitude * unit(e, tick) / 127);
}
