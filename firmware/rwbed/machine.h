/* What the board does: disarmed, arming, armed or in a latched fault. Knows no register; one call a tick. */
#ifndef MACHINE_H
#define MACHINE_H

#include <stdint.h>

#include "experiment.h"
#include "frame.h"
#include "law.h"

enum state { DISARMED, ARMING, ARMED, FAULT };

enum fault { FAULT_SILENCE = 1, FAULT_SPEED = 2, FAULT_BATTERY = 4, FAULT_TICKS = 8 }; /* bits */

enum type { /* of frames: commands, then what the board says */
    ASK = 0x01,       /* for HELLO */
    HEARTBEAT = 0x02,
    ARM = 0x03,       /* nonce u32, of this boot's HELLO */
    DISARM = 0x04,
    CLEAR = 0x05,     /* a fault; leads to DISARMED */
    PULSE = 0x06,     /* widths u16, u16 */
    HOLD = 0x07,      /* output u8, reference i32, kp i16, kd i16, breakaway u16: PD on its encoder 1 */
    PLAY = 0x08,      /* output u8, kind u8, amplitude i16, offset i16, period u16, length u32 */
    HELLO = 0x81,
    SAMPLE = 0x82,
    ACK = 0x83,       /* seq u16 and type u8 of the command, result u8 */
};

enum result { DONE, UNKNOWN, WRONG_LENGTH, STALE, WRONG_NONCE, OUT_OF_RANGE, NOT_NOW };

enum mode { WIDTHS, HOLDING, PLAYING };

struct readings { /* of one tick */
    uint32_t tick;
    int32_t count[2];
    uint16_t in_force[2]; /* widths of the pulses that begin with this tick */
    uint16_t battery;     /* mV */
    uint8_t missed;       /* ticks that nobody answered before this one */
    uint16_t dropped;     /* frames for which the line had no room */
    uint8_t overruns;     /* bytes that came too fast */
};

struct machine {
    uint8_t state, faults, mode, output;
    uint8_t heard; /* a command has been accepted, `seq` is valid */
    uint16_t seq;  /* of the last command accepted */
    uint16_t waited, silence, low;
    uint16_t missed, damaged; /* ticks, frames since boot */
    uint32_t nonce, played;
    int32_t count[2], moved[2];
    uint16_t width[2]; /* of the next pulses */
    struct law law;
    struct experiment experiment;
};

void machine_init(struct machine *m, uint32_t nonce);
/* Acts on a whole command or not at all; its result is for the ACK. */
uint8_t machine_command(struct machine *m, const struct frame *command);
void machine_damaged(struct machine *m);
void machine_tick(struct machine *m, const struct readings *now, uint8_t first);

/* What the board says; `frame->seq` is the caller's. */
void machine_hello(const struct machine *m, uint8_t reset_cause, struct frame *frame);
void machine_sample(const struct machine *m, const struct readings *now, struct frame *frame);
void machine_ack(const struct frame *command, uint8_t result, struct frame *frame);

#endif
