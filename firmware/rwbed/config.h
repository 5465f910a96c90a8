/* Numbers of the testbed. Times of the tick, widths of the pulses and counts have these units throughout the firmware. */
#ifndef CONFIG_H
#define CONFIG_H

#define PROTOCOL 1        /* of the frames; raised when a body changes */
#define TICK_HZ 100       /* one tick, one pulse on each output, one sample on the wire */
#define TICKS(ms) ((uint16_t)((ms) * (uint32_t)TICK_HZ / 1000))
#define HALF_US(us) ((uint16_t)(2 * (us))) /* widths count half microseconds: timer 1 at 16 MHz / 8 */

#ifndef BAUD
#define BAUD 250000UL /* divides 16 MHz exactly, 8 times what the samples need; 115200 is 2.1 % off */
#endif

#define PULSE_MIN HALF_US(1000)
#define PULSE_MAX HALF_US(2000)
#ifndef PULSE_NEUTRAL
#define PULSE_NEUTRAL HALF_US(1500) /* of an ESC that turns both ways; PULSE_MIN for one that turns one way */
#endif

#define ARM_TICKS TICKS(1000)    /* neutral this long before anything else: the ESC arms itself meanwhile */
#define SILENCE_TICKS TICKS(200) /* without a valid command: fault */
#define MOST_MISSED 3            /* ticks missed in a row: fault */
#define BATTERY_LOWEST 9000      /* mV, a 3S battery at 3 V a cell; a supply below it is a fault */
#define BATTERY_TICKS TICKS(500) /* this long below it: a motor that starts draws it down for less */
#define BATTERY_FULL 18000L      /* mV at 5 V on the ADC pin: divider 18:5 */

/* Counts (both edges of A) in a turn, and most of them in a tick: 70 % of the rate up to which none is lost while both
   encoders turn as fast (docs/firmware.md); above it: fault. 630 in 10 ms are 1846 rpm of 1024 lines. */
#define COUNTS_PER_REV_1 2048
#define COUNTS_PER_REV_2 2048
#define MOST_COUNTS 630

/* Where counters begin; tests start them just before they wrap around. */
#ifndef FIRST_TICK
#define FIRST_TICK 0
#endif
#ifndef FIRST_SEQ
#define FIRST_SEQ 0
#endif
#ifndef FIRST_COUNT
#define FIRST_COUNT 0
#endif
#ifndef FIRMWARE_HASH
#define FIRMWARE_HASH 0 /* of these sources, given by the Makefile; 0 from the Arduino IDE */
#endif

#endif
