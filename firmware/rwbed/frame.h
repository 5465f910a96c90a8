/* Frames on the wire: COBS(type u8, seq u16, body, crc u16), then a zero, which stands nowhere else.

   Whatever is lost or damaged, the next zero begins anew. CRC-16/IBM-3740 over type to body. */
#ifndef FRAME_H
#define FRAME_H

#include <stdint.h>

#define BODY_LONGEST 48
#define PLAIN_LONGEST (3 + BODY_LONGEST + 2)
#define WIRE_LONGEST (PLAIN_LONGEST + 2) /* one byte of COBS (below 254 bytes), one zero */

struct frame {
    uint8_t type, length; /* of the body */
    uint16_t seq;
    uint8_t body[BODY_LONGEST];
};

struct receiver {
    uint8_t wire[WIRE_LONGEST];
    uint8_t length; /* bytes since the last zero; WIRE_LONGEST and more are too long for a frame */
};

enum received { NOTHING, FRAME, DAMAGED };

uint16_t frame_crc(const uint8_t *data, uint8_t length);
/* Bytes of `frame` written to `wire`, the zero included. */
uint8_t frame_encode(const struct frame *frame, uint8_t wire[WIRE_LONGEST]);
/* Takes one byte; FRAME when it completes a good frame, which is then in `frame`. */
enum received frame_receive(struct receiver *receiver, uint8_t byte, struct frame *frame);

#endif
