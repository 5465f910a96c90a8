/* Counts that do not wrap with the 16 bits of the encoders' interrupts. */
#ifndef DECODE_H
#define DECODE_H

#include <stdint.h>

/* The count nearest `count` whose low 16 bits are `edges`: right up to 32767 counts between two calls. */
int32_t decode_widen(int32_t count, uint16_t edges);

#endif
