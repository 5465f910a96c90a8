/* Registers of the ATmega328P (Uno, Nano) and ATmega2560 (Mega).

   Timer 1 counts half microseconds and overflows 100 times a second: every overflow begins two pulses and is the tick.
   Timers 0 and 2 stand still. Interrupts count, copy and set a bit of EVENTS; the loop does the rest.
   An edge of an encoder waits for at most one other interrupt's few instructions (docs/firmware.md has the speeds). */
#include "board.h"

#include <avr/eeprom.h>
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <avr/wdt.h>
#include <util/atomic.h>

#include "config.h"
#include "decode.h"

_Static_assert(F_CPU == 16000000UL, "widths and ticks count at 16 MHz / 8");
_Static_assert(F_CPU % (8 * BAUD) == 0, "the line's rate divides the clock exactly");
_Static_assert(F_CPU / 8 / TICK_HZ <= 65536UL, "a tick fits timer 1");

#define TICK_LENGTH (F_CPU / 8 / TICK_HZ) /* half us */

/* Encoder 1: A on INT0, B two pins on; encoder 2: A on INT1, B two pins on. Both need pull-ups outside. */
#if defined(__AVR_ATmega328P__)
#define PULSE_PINS (_BV(PB1) | _BV(PB2)) /* D9, D10 */
#define A_1 2 /* D2, B on D4 */
#define A_2 3 /* D3, B on D5 */
#define RECEIVED_vect USART_RX_vect
#define EMPTY_vect USART_UDRE_vect
#elif defined(__AVR_ATmega2560__)
#define PULSE_PINS (_BV(PB5) | _BV(PB6)) /* D11, D12 */
#define A_1 0 /* D21, B on D19 */
#define A_2 1 /* D20, B on D18 */
#define RECEIVED_vect USART0_RX_vect
#define EMPTY_vect USART0_UDRE_vect
#else
#error "an ATmega328P or ATmega2560 is needed"
#endif

/* Bits of EVENTS, each set by one interrupt in one instruction. */
#define EVENTS GPIOR0
#define TICKED 0
#define BYTES 1
#define ENDED_1 2 /* this tick's pulse has ended: the next width may be written */
#define ENDED_2 3

static volatile uint16_t edges[2] = {(uint16_t)FIRST_COUNT, (uint16_t)FIRST_COUNT};
static volatile struct {
    uint32_t tick;
    uint16_t edges[2], in_force[2];
} latest = {.tick = FIRST_TICK - 1UL};

static uint8_t wanted = _BV(TICKED) | _BV(BYTES); /* events for which the loop wakes */
static uint16_t next[2] = {PULSE_NEUTRAL, PULSE_NEUTRAL};
static uint8_t reset_cause __attribute__((section(".noinit")));

static volatile uint8_t out[256], in[64];
static volatile uint8_t out_head, out_tail, in_head, in_tail, overruns;
static uint16_t dropped;

/* Both edges of A. Forward, (A, B) goes 00, 10, 11, 01: after an edge of A the two differ, +1. Backward they agree, -1. */
#define ENCODER(vector, a_bit, counter)                                                                               \
    ISR(vector, ISR_NAKED) {                                                                                          \
        __asm__ volatile("push r25\n\t"                                                                               \
                         "in r25, %[pins]\n\t"                                                                        \
                         "push r24\n\t"                                                                               \
                         "in r24, __SREG__\n\t"                                                                       \
                         "push r24\n\t"                                                                               \
                         "mov r24, r25\n\t"                                                                           \
                         "lsr r24\n\t"                                                                                \
                         "lsr r24\n\t" /* B stands where A does in r25 */                                             \
                         "eor r25, r24\n\t"                                                                           \
                         "lds r24, %[count]\n\t"                                                                      \
                         "sbrs r25, %[a]\n\t"                                                                         \
                         "rjmp 1f\n\t"                                                                                \
                         "inc r24\n\t"                                                                                \
                         "sts %[count], r24\n\t"                                                                      \
                         "brne 2f\n\t"                                                                                \
                         "lds r24, %[count]+1\n\t"                                                                    \
                         "inc r24\n\t"                                                                                \
                         "sts %[count]+1, r24\n\t"                                                                    \
                         "rjmp 2f\n\t"                                                                                \
                         "1: subi r24, 1\n\t"                                                                         \
                         "sts %[count], r24\n\t"                                                                      \
                         "brcc 2f\n\t"                                                                                \
                         "lds r24, %[count]+1\n\t"                                                                    \
                         "dec r24\n\t"                                                                                \
                         "sts %[count]+1, r24\n\t"                                                                    \
                         "2: pop r24\n\t"                                                                             \
                         "out __SREG__, r24\n\t"                                                                      \
                         "pop r24\n\t"                                                                                \
                         "pop r25\n\t"                                                                                \
                         "reti" ::[pins] "I"(_SFR_IO_ADDR(PIND)),                                                     \
                         [a] "I"(a_bit), [count] "i"(&(counter)));                                                    \
    }
ENCODER(INT0_vect, A_1, edges[0])
ENCODER(INT1_vect, A_2, edges[1])

#define MARK(vector, bit)                                                                                             \
    ISR(vector, ISR_NAKED) {                                                                                          \
        __asm__ volatile("sbi %0, %1\n\treti" ::"I"(_SFR_IO_ADDR(EVENTS)), "I"(bit));                                 \
    }
MARK(TIMER1_COMPA_vect, ENDED_1)
MARK(TIMER1_COMPB_vect, ENDED_2)

ISR(TIMER1_OVF_vect, ISR_NOBLOCK) {
    uint16_t a, b;
    ATOMIC_BLOCK(ATOMIC_FORCEON) {
        a = edges[0];
        b = edges[1];
    }
    latest.edges[0] = a;
    latest.edges[1] = b;
    latest.in_force[0] = OCR1A + 1;
    latest.in_force[1] = OCR1B + 1;
    latest.tick++;
    EVENTS &= (uint8_t)~_BV(ENDED_1);
    EVENTS &= (uint8_t)~_BV(ENDED_2);
    EVENTS |= _BV(TICKED);
}

/* An interrupt of the line that cannot come again until `body` allows it, and lets the encoders in after 24 cycles. */
#define LINE(vector, enable, body)                                                                                    \
    void body(void) __attribute__((signal, used));                                                                    \
    ISR(vector, ISR_NAKED) {                                                                                          \
        __asm__ volatile("push r24\n\t"                                                                               \
                         "in r24, __SREG__\n\t"                                                                       \
                         "push r24\n\t"                                                                               \
                         "lds r24, %[control]\n\t"                                                                    \
                         "andi r24, %[mask]\n\t"                                                                      \
                         "sts %[control], r24\n\t"                                                                    \
                         "pop r24\n\t"                                                                                \
                         "out __SREG__, r24\n\t"                                                                      \
                         "pop r24\n\t"                                                                                \
                         "sei\n\t"                                                                                    \
                         "jmp " #body ::[control] "n"(_SFR_MEM_ADDR(UCSR0B)),                                         \
                         [mask] "M"(0xFF & ~_BV(enable)));                                                            \
    }                                                                                                                 \
    void body(void)

LINE(RECEIVED_vect, RXCIE0, __vector_received) {
    if (UCSR0A & _BV(DOR0) && overruns < 255)
        overruns++;
    uint8_t byte = UDR0, head = (uint8_t)((in_head + 1) % sizeof in);
    if (head != in_tail) {
        in[in_head] = byte;
        in_head = head;
    } else if (overruns < 255) {
        overruns++;
    }
    EVENTS |= _BV(BYTES);
    ATOMIC_BLOCK(ATOMIC_FORCEON) { UCSR0B |= _BV(RXCIE0); }
}

LINE(EMPTY_vect, UDRIE0, __vector_empty) {
    uint8_t tail = out_tail;
    UDR0 = out[tail];
    out_tail = ++tail;
    if (tail != out_head)
        ATOMIC_BLOCK(ATOMIC_FORCEON) { UCSR0B |= _BV(UDRIE0); }
}

void board_first(void) __attribute__((naked, used, section(".init3")));
void board_first(void) { /* before any variable is set: a watchdog that fired is still running */
    reset_cause = MCUSR;
    MCUSR = 0;
    wdt_disable();
}

uint8_t board_reset_cause(void) { return reset_cause; }

uint32_t board_boots(void) {
    static uint32_t EEMEM stored;
    uint32_t boots = eeprom_read_dword(&stored) + 1;
    eeprom_write_dword(&stored, boots);
    eeprom_busy_wait();
    return boots;
}

void board_init(void) {
    OCR1A = OCR1B = PULSE_NEUTRAL - 1; /* in mode 0, where they are not buffered */
    TCCR1A = _BV(COM1A1) | _BV(COM1B1) | _BV(WGM11);
    TCCR1B = _BV(WGM13) | _BV(WGM12); /* mode 14, standing still: ICR1 can be written in a mode that ends at it, no other */
    ICR1 = TICK_LENGTH - 1;
    DDRB |= PULSE_PINS;
    TIMSK1 = _BV(TOIE1) | _BV(OCIE1A) | _BV(OCIE1B);
    TCCR1B |= _BV(CS11); /* clock / 8 */

    EICRA = _BV(ISC00) | _BV(ISC10); /* any edge */
    EIMSK = _BV(INT0) | _BV(INT1);

    ADMUX = _BV(REFS0); /* of the supply, input 0 */
    ADCSRA = _BV(ADEN) | _BV(ADSC) | _BV(ADPS2) | _BV(ADPS1) | _BV(ADPS0);

    UCSR0A = _BV(U2X0);
    UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
    UBRR0 = F_CPU / 8 / BAUD - 1;
    UCSR0B = _BV(RXEN0) | _BV(TXEN0) | _BV(RXCIE0);

    set_sleep_mode(SLEEP_MODE_IDLE);
    wdt_enable(WDTO_60MS);
    sei();
}

static void write_width(uint8_t bit, volatile uint16_t *compare, uint16_t width) {
    if (wanted & EVENTS & _BV(bit)) {
        ATOMIC_BLOCK(ATOMIC_FORCEON) { *compare = width - 1; }
        wanted &= (uint8_t)~_BV(bit);
    }
}

void board_sleep(void) {
    cli();
    if (EVENTS & wanted) {
        sei();
    } else {
        sleep_enable();
        sei(); /* takes effect after the next instruction: no event slips in between */
        sleep_cpu();
        sleep_disable();
    }
    write_width(ENDED_1, &OCR1A, next[0]);
    write_width(ENDED_2, &OCR1B, next[1]);
}

static uint16_t clamped(uint16_t width) { /* once more than the machine does */
    return width < PULSE_MIN ? PULSE_MIN : width > PULSE_MAX ? PULSE_MAX : width;
}

void board_widths(const uint16_t width[2]) {
    next[0] = clamped(width[0]);
    next[1] = clamped(width[1]);
    wanted |= _BV(ENDED_1) | _BV(ENDED_2);
}

uint8_t board_tick(struct readings *now) {
    static int32_t count[2] = {FIRST_COUNT, FIRST_COUNT};
    static uint32_t before = FIRST_TICK - 1UL;
    uint16_t edge[2];
    if (!(EVENTS & _BV(TICKED)))
        return 0;
    EVENTS &= (uint8_t)~_BV(TICKED);
    do { /* the encoders are not to wait for this copy: it is made again where a tick came in between */
        now->tick = latest.tick;
        for (uint8_t k = 0; k < 2; k++) {
            now->in_force[k] = latest.in_force[k];
            edge[k] = latest.edges[k];
        }
    } while (now->tick != latest.tick);
    if (now->tick == before)
        return 0; /* it was copied the time before, just as it came */
    now->missed = (uint8_t)(now->tick - before - 1); /* the watchdog bites before there are 256 */
    before = now->tick;
    for (uint8_t k = 0; k < 2; k++)
        now->count[k] = count[k] = decode_widen(count[k], edge[k]);
    now->battery = (uint16_t)(ADC * BATTERY_FULL / 1024); /* converted when the tick before was taken */
    ADCSRA |= _BV(ADSC);
    now->dropped = dropped;
    now->overruns = overruns;
    return 1;
}

uint8_t board_received(uint8_t *byte) {
    EVENTS &= (uint8_t)~_BV(BYTES); /* before the look: a byte that comes after it wakes the loop again */
    if (in_head == in_tail)
        return 0;
    *byte = in[in_tail];
    in_tail = (uint8_t)((in_tail + 1) % sizeof in);
    return 1;
}

void board_send(const uint8_t *data, uint8_t length) {
    if ((uint8_t)(out_tail - out_head - 1) < length) {
        if (dropped < UINT16_MAX)
            dropped++;
        return;
    }
    for (uint8_t k = 0, head = out_head; k < length; k++)
        out[head++] = data[k];
    out_head = (uint8_t)(out_head + length);
    ATOMIC_BLOCK(ATOMIC_FORCEON) { UCSR0B |= _BV(UDRIE0); }
}

void board_alive(void) { wdt_reset(); }
