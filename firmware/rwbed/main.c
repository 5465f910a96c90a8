/* The loop: a byte, a tick, sleep. */
#include "board.h"
#include "config.h"
#include "frame.h"
#include "machine.h"

static struct machine machine;
static struct receiver receiver;
static uint16_t seq = FIRST_SEQ;

static void send(struct frame *frame) {
    uint8_t wire[WIRE_LONGEST];
    frame->seq = seq++; /* also where the line has no room: the host sees the gap */
    board_send(wire, frame_encode(frame, wire));
}

static void say_hello(void) {
    struct frame hello;
    machine_hello(&machine, board_reset_cause(), &hello);
    send(&hello);
}

static void obey(const struct frame *command) {
    struct frame ack;
    machine_ack(command, machine_command(&machine, command), &ack);
    send(&ack);
    if (command->type == ASK)
        say_hello();
#ifdef HANG_ON_CLEAR /* a build for the watchdog's test */
    if (command->type == CLEAR)
        for (;;) {
        }
#endif
}

static void receive(void) {
    struct frame command;
    uint8_t byte;
    while (board_received(&byte)) {
        enum received received = frame_receive(&receiver, byte, &command);
        if (received == FRAME)
            obey(&command);
        else if (received == DAMAGED)
            machine_damaged(&machine);
    }
}

static void tick(const struct readings *now) {
    static uint8_t later;
    struct frame sample;
    machine_tick(&machine, now, !later);
    later = 1;
    board_widths(machine.width);
    machine_sample(&machine, now, &sample);
    send(&sample);
    board_alive();
}

int main(void) {
    struct readings now;
    machine_init(&machine, board_boots());
    board_init();
    say_hello();
    for (;;) {
        board_sleep();
        receive();
        if (board_tick(&now))
            tick(&now);
    }
}
