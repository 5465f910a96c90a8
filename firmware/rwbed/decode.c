#include "decode.h"

int32_t decode_widen(int32_t count, uint16_t edges) {
    uint16_t before = (uint16_t)(uint32_t)count;
    return (int32_t)((uint32_t)count + (uint32_t)(int32_t)(int16_t)(uint16_t)(edges - before));
}
