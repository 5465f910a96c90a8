#include "frame.h"

#include <string.h>

#include "bytes.h"

uint16_t frame_crc(const uint8_t *data, uint8_t length) {
    uint16_t crc = 0xFFFF;
    while (length--) {
        crc ^= (uint16_t)((uint16_t)*data++ << 8);
        for (uint8_t bit = 0; bit < 8; bit++)
            crc = (uint16_t)(crc & 0x8000 ? (uint16_t)(crc << 1) ^ 0x1021 : crc << 1);
    }
    return crc;
}

uint8_t frame_encode(const struct frame *frame, uint8_t wire[WIRE_LONGEST]) {
    uint8_t plain[PLAIN_LONGEST], *end = put16(put8(plain, frame->type), frame->seq);
    memcpy(end, frame->body, frame->length);
    end += frame->length;
    end = put16(end, frame_crc(plain, (uint8_t)(end - plain)));

    uint8_t *code = wire, *to = wire + 1; /* a code counts the bytes up to the next zero of the plain text */
    for (const uint8_t *from = plain; from < end; from++) {
        if (*from) {
            *to++ = *from;
        } else {
            *code = (uint8_t)(to - code);
            code = to++;
        }
    }
    *code = (uint8_t)(to - code);
    *to++ = 0;
    return (uint8_t)(to - wire);
}

static int decode(const uint8_t *wire, uint8_t length, struct frame *frame) {
    uint8_t plain[WIRE_LONGEST], n = 0;
    for (uint8_t at = 0; at < length;) {
        uint8_t code = wire[at];
        if (at + code > length)
            return 0;
        if (at)
            plain[n++] = 0;
        memcpy(plain + n, wire + at + 1, code - 1u);
        n = (uint8_t)(n + code - 1);
        at = (uint8_t)(at + code);
    }
    if (n < 5 || n > PLAIN_LONGEST || get16(plain + n - 2) != frame_crc(plain, (uint8_t)(n - 2)))
        return 0;
    frame->type = plain[0];
    frame->seq = get16(plain + 1);
    frame->length = (uint8_t)(n - 5);
    memcpy(frame->body, plain + 3, frame->length);
    return 1;
}

enum received frame_receive(struct receiver *receiver, uint8_t byte, struct frame *frame) {
    if (byte) {
        if (receiver->length < WIRE_LONGEST)
            receiver->wire[receiver->length++] = byte;
        return NOTHING;
    }
    uint8_t length = receiver->length;
    receiver->length = 0;
    if (length == 0)
        return NOTHING; /* two zeros in a row: a sender making sure of a clean start */
    return length < WIRE_LONGEST && decode(receiver->wire, length, frame) ? FRAME : DAMAGED;
}
