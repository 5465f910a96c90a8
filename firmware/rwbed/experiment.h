/* Experiments that the board plays by itself: a pure function of the tick. */
#ifndef EXPERIMENT_H
#define EXPERIMENT_H

#include <stdint.h>

enum experiment_kind { COAST_DOWN, SQUARE, TRIANGLE, STAIRCASE, MULTISINE, EXPERIMENT_KINDS };

#define REST_TICKS 60    /* neutral before every experiment: a log's first 0.5 s tell where it starts */
#define STAIRS 8         /* steps of a staircase from -amplitude to +amplitude */
#define WAVE_SAMPLES 256 /* of the multisine's table in one period */

struct experiment {
    uint8_t kind;
    int16_t amplitude; /* half us */
    int16_t offset;    /* half us */
    uint16_t period;   /* ticks; coast-down: ticks of drive before the wheel runs free */
    uint32_t length;   /* ticks after the rest */
};

/* Width from neutral [half us]; 0 before and after. */
int16_t experiment_width(const struct experiment *experiment, uint32_t tick);
uint8_t experiment_over(const struct experiment *experiment, uint32_t tick);

#endif
