#include "machine.h"

#include "bytes.h"
#include "config.h"

#define SPAN (PULSE_MAX - PULSE_NEUTRAL) /* half us, largest command either way */
#define LONGEST (3600UL * TICK_HZ)       /* ticks, of an experiment */

_Static_assert(PULSE_MIN <= PULSE_NEUTRAL && PULSE_NEUTRAL + (PULSE_MAX - PULSE_MIN) / 6 <= PULSE_MAX,
               "PULSE_NEUTRAL: not below PULSE_MIN, nor so near to PULSE_MAX that next to nothing is left to command");

static void neutral(struct machine *m) {
    m->width[0] = m->width[1] = PULSE_NEUTRAL;
}

static void enter(struct machine *m, uint8_t state) {
    m->state = state;
    m->mode = WIDTHS;
    m->waited = m->silence = m->low = 0;
    neutral(m);
}

void machine_init(struct machine *m, uint32_t nonce) {
    *m = (struct machine){.nonce = nonce};
    enter(m, DISARMED);
}

void machine_damaged(struct machine *m) {
    if (m->damaged < UINT16_MAX)
        m->damaged++;
}

static void fail(struct machine *m, uint8_t fault) {
    m->faults |= fault;
    enter(m, FAULT);
}

static uint8_t arm(struct machine *m, uint32_t nonce) {
    if (nonce != m->nonce)
        return WRONG_NONCE;
    if (m->state != DISARMED)
        return NOT_NOW;
    enter(m, ARMING);
    return DONE;
}

static uint8_t clear(struct machine *m) {
    if (m->state != FAULT)
        return NOT_NOW;
    m->faults = 0;
    enter(m, DISARMED);
    return DONE;
}

static uint8_t legal(uint16_t width) { return width >= PULSE_MIN && width <= PULSE_MAX; }

static uint8_t widths(struct machine *m, uint16_t a, uint16_t b) {
    if (!legal(a) || !legal(b))
        return OUT_OF_RANGE;
    if (m->state != ARMED)
        return NOT_NOW;
    m->mode = WIDTHS;
    m->width[0] = a;
    m->width[1] = b;
    return DONE;
}

static uint8_t hold(struct machine *m, const uint8_t *body) {
    struct law law = {
        .reference = (int32_t)get32(body + 1),
        .kp = (int16_t)get16(body + 5),
        .kd = (int16_t)get16(body + 7),
        .breakaway = get16(body + 9),
    };
    if (body[0] > 1 || law.breakaway > SPAN)
        return OUT_OF_RANGE;
    if (m->state != ARMED)
        return NOT_NOW;
    neutral(m);
    m->mode = HOLDING;
    m->output = body[0];
    m->law = law;
    return DONE;
}

static uint8_t play(struct machine *m, const uint8_t *body) {
    struct experiment e = {
        .kind = body[1],
        .amplitude = (int16_t)get16(body + 2),
        .offset = (int16_t)get16(body + 4),
        .period = get16(body + 6),
        .length = get32(body + 8),
    };
    int32_t reach = (e.amplitude < 0 ? -(int32_t)e.amplitude : e.amplitude) + (e.offset < 0 ? -(int32_t)e.offset : e.offset);
    if (body[0] > 1 || e.kind >= EXPERIMENT_KINDS || reach > SPAN || e.period < 4 || e.length > LONGEST)
        return OUT_OF_RANGE;
    if (m->state != ARMED)
        return NOT_NOW;
    neutral(m);
    m->mode = PLAYING;
    m->output = body[0];
    m->experiment = e;
    m->played = 0;
    return DONE;
}

static uint8_t length_of(uint8_t type) { /* of a command's body; 255: unknown */
    switch (type) {
    case ASK:
    case HEARTBEAT:
    case DISARM:
    case CLEAR:
        return 0;
    case ARM:
    case PULSE:
        return 4;
    case HOLD:
        return 11;
    case PLAY:
        return 12;
    default:
        return 255;
    }
}

static uint8_t act(struct machine *m, const struct frame *command) {
    const uint8_t *body = command->body;
    switch (command->type) {
    case ARM:
        return arm(m, get32(body));
    case DISARM:
        if (m->state != FAULT)
            enter(m, DISARMED);
        return DONE;
    case CLEAR:
        return clear(m);
    case PULSE:
        return widths(m, get16(body), get16(body + 2));
    case HOLD:
        return hold(m, body);
    case PLAY:
        return play(m, body);
    default: /* HEARTBEAT */
        return DONE;
    }
}

uint8_t machine_command(struct machine *m, const struct frame *command) {
    uint8_t length = length_of(command->type);
    if (length == 255)
        return UNKNOWN;
    if (command->length != length)
        return WRONG_LENGTH;
    if (command->type == ASK)
        return DONE; /* whatever its number: a host that has just come learns the last one from HELLO */
    if (m->heard && (int16_t)(command->seq - m->seq) <= 0)
        return STALE;
    uint8_t result = act(m, command);
    if (result == DONE) {
        m->heard = 1;
        m->seq = command->seq;
        m->silence = 0;
    }
    return result;
}

static uint8_t too_fast(int32_t moved) { return moved > MOST_COUNTS || moved < -MOST_COUNTS; }

static void watch(struct machine *m, const struct readings *now) {
    m->silence++;
    m->low = now->battery < BATTERY_LOWEST ? m->low + 1 : 0;
    if (m->silence > SILENCE_TICKS)
        fail(m, FAULT_SILENCE);
    if (too_fast(m->moved[0]) || too_fast(m->moved[1]))
        fail(m, FAULT_SPEED);
    if (m->low > BATTERY_TICKS)
        fail(m, FAULT_BATTERY);
    if (now->missed >= MOST_MISSED)
        fail(m, FAULT_TICKS);
}

static void drive(struct machine *m) {
    if (m->mode == WIDTHS)
        return;
    int16_t from_neutral = m->mode == HOLDING ? law_width(&m->law, m->count[0], m->moved[0], SPAN)
                                              : experiment_width(&m->experiment, m->played++);
    int16_t width = (int16_t)(PULSE_NEUTRAL + from_neutral);
    if (width < (int16_t)PULSE_MIN) /* an ESC that turns one way has nothing below neutral */
        width = PULSE_MIN;
    m->width[m->output] = (uint16_t)width;
}

void machine_tick(struct machine *m, const struct readings *now, uint8_t first) {
    for (uint8_t k = 0; k < 2; k++) {
        m->moved[k] = first ? 0 : (int32_t)((uint32_t)now->count[k] - (uint32_t)m->count[k]) / (now->missed + 1);
        m->count[k] = now->count[k];
    }
    m->missed = (uint16_t)(m->missed + now->missed);
    if (m->state == ARMING || m->state == ARMED)
        watch(m, now);
    if (m->state == ARMING && ++m->waited >= ARM_TICKS)
        m->state = ARMED; /* silence and a low battery go on counting */
    if (m->state == ARMED)
        drive(m);
}

void machine_hello(const struct machine *m, uint8_t reset_cause, struct frame *frame) {
    uint8_t *p = frame->body;
    frame->type = HELLO;
    p = put32(put32(put8(p, PROTOCOL), FIRMWARE_HASH), m->nonce);
    p = put16(put16(put8(put8(p, reset_cause), m->heard), m->seq), TICK_HZ);
    p = put16(put16(p, COUNTS_PER_REV_1), COUNTS_PER_REV_2);
    p = put16(put16(put16(p, PULSE_MIN), PULSE_NEUTRAL), PULSE_MAX);
    p = put16(put16(put16(put16(p, ARM_TICKS), SILENCE_TICKS), MOST_COUNTS), BATTERY_LOWEST);
    frame->length = (uint8_t)(p - frame->body);
}

void machine_sample(const struct machine *m, const struct readings *now, struct frame *frame) {
    uint8_t *p = frame->body, playing = m->mode == PLAYING && !experiment_over(&m->experiment, m->played);
    frame->type = SAMPLE;
    p = put32(put32(put32(p, now->tick), (uint32_t)now->count[0]), (uint32_t)now->count[1]);
    p = put16(put16(put16(p, now->in_force[0]), now->in_force[1]), now->battery);
    p = put8(put8(put8(p, m->state), m->faults), playing);
    p = put8(put16(put16(put16(p, m->missed), now->dropped), m->damaged), now->overruns);
    frame->length = (uint8_t)(p - frame->body);
}

void machine_ack(const struct frame *command, uint8_t result, struct frame *frame) {
    frame->type = ACK;
    frame->length = (uint8_t)(put8(put8(put16(frame->body, command->seq), command->type), result) - frame->body);
}
