/* The hardware, as the rest of the firmware sees it. board_avr.c is the only file that touches a register. */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

#include "machine.h"

/* Neutral pulses, encoders, line and tick; interrupts on. */
void board_init(void);
uint8_t board_reset_cause(void); /* MCUSR as it was at boot */
/* Boots of this board so far: no two boots share a number, so it serves as nonce. */
uint32_t board_boots(void);
void board_sleep(void);
/* Whether a tick has come since the last call; then its readings. */
uint8_t board_tick(struct readings *now);
/* Widths [half us] of the pulses that begin with the next tick, if set before this tick's have ended. */
void board_widths(const uint16_t width[2]);
uint8_t board_received(uint8_t *byte);
/* A whole frame or, where the line has no room, nothing of it. */
void board_send(const uint8_t *data, uint8_t length);
void board_alive(void); /* without it for 60 ms: reset */

#endif
