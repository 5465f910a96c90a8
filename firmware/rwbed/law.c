#include "law.h"

#define LARGEST 16383 /* counts: two products of it with 16-bit gains add up within 32 bits */

static int32_t within(int32_t value, int32_t limit) {
    return value > limit ? limit : value < -limit ? -limit : value;
}

int16_t law_width(const struct law *law, int32_t count, int32_t moved, int16_t limit) {
    int32_t error = (int32_t)((uint32_t)law->reference - (uint32_t)count);
    int32_t u = law->kp * within(error, LARGEST) - law->kd * within(moved, LARGEST);
    u = within(u / 256, limit); /* the sum is divided, not its parts: small gains keep their digits */
    if (u > 0)
        u += law->breakaway;
    else if (u < 0)
        u -= law->breakaway;
    return (int16_t)within(u, limit);
}
