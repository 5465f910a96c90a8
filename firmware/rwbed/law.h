/* PD law with feed-forward, in counts and half microseconds. */
#ifndef LAW_H
#define LAW_H

#include <stdint.h>

struct law {
    int32_t reference;    /* counts */
    int16_t kp;           /* 1/256 half us per count */
    int16_t kd;           /* 1/256 half us per count of a tick */
    uint16_t breakaway;   /* half us, added in the direction of the command: dead band and dry friction */
};

/* Width from neutral [half us] at `count`, `moved` counts after the last tick; within +-`limit`. */
int16_t law_width(const struct law *law, int32_t count, int32_t moved, int16_t limit);

#endif
