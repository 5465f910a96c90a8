/* An ATmega in simavr, driven from Python by ctypes: edges in, pulses and bytes out, no clock of the wall anywhere.

   What is worked around here, in simavr 1.6 (never in the firmware):
   - timer 1's mode 14 has the wrong kind on the 328P: a new width would never show (upstream issue 579)
   - a write that changes only the high byte of OCR1x is dropped: every write forces a new look at the registers
   - ICR1 can be written in any mode: a write without WGM13 is dropped, as the silicon does
   - external interrupts in level mode poll on every cycle, even when masked
   - a watchdog reset wipes timers and pin levels of the simulation: they are set up again
   - an interrupt's entry costs nothing: the cycles of the silicon are added
   - a timer's edges wait for the instruction in progress: they are put where the timer has them
   - OCR1x is not double buffered: a longer width, written after the pulse has ended, begins a second pulse in the same
     period, which the silicon cannot. It is left out; a width written while the pulse lasts still shows. */
#include <simavr/avr_adc.h>
#include <simavr/avr_extint.h>
#include <simavr/avr_ioport.h>
#include <simavr/avr_timer.h>
#include <simavr/avr_uart.h>
#include <simavr/sim_avr.h>
#include <simavr/sim_cycle_timers.h>
#include <simavr/sim_elf.h>
#include <simavr/sim_io.h>
#include <simavr/sim_time.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define PINS 8
#define PERIOD_SHORTEST 400 /* Hz */
#define LATE 16 /* cycles, most of an edge behind its timer */
#define ADC_INPUTS 8
#define DEPTH 32 /* of nested interrupts */

struct edge { uint64_t cycle; uint8_t pin, level; };
struct pulse { uint64_t rise; uint32_t cycles; uint32_t output; };
struct byte { uint64_t cycle; uint8_t value; };
struct entry { uint64_t enter, leave; uint32_t vector; };

#define QUEUE(type, name) struct { struct type *at; size_t first, n, room; } name

struct sim {
    avr_t *avr;
    void (*core_reset)(avr_t *);
    uint32_t entry_cycles, byte_cycles;
    int stop, reset_seen, resets;
    uint8_t level[PINS], driven[PINS];
    avr_irq_t *pin[PINS];
    avr_timer_t *timer;
    uint32_t adc[ADC_INPUTS];
    uint64_t rise[2];
    uint8_t high[2];
    size_t depth, open[DEPTH];
    int watch_entries;
    QUEUE(edge, edges);
    QUEUE(byte, to_avr);
    QUEUE(byte, from_avr);
    QUEUE(pulse, pulses);
    QUEUE(entry, entries);
};

#define PUSH(q, ...)                                                                                                  \
    do {                                                                                                              \
        if ((q).first == (q).n)                                                                                       \
            (q).first = (q).n = 0;                                                                                    \
        if ((q).n == (q).room)                                                                                        \
            (q).at = realloc((q).at, ((q).room = 2 * (q).room + 64) * sizeof *(q).at);                                \
        (q).at[(q).n++] = __VA_ARGS__;                                                                                \
    } while (0)

static struct sim *of(avr_t *avr) { return avr->custom.data; }

static void no_log(avr_t *avr, const int level, const char *format, va_list arguments) {
    (void)avr, (void)level, (void)format, (void)arguments;
}

static void no_sleep(avr_t *avr, avr_cycle_count_t cycles) { (void)avr, (void)cycles; }

static void on_reset(avr_t *avr) {
    struct sim *s = of(avr);
    s->core_reset(avr);
    s->reset_seen = 1;
}

static void on_width(avr_irq_t *irq, uint32_t value, void *avr) {
    uint8_t zero = 0;
    (void)irq, (void)value;
    avr_ioctl(avr, AVR_IOCTL_TIMER_SET_VIRTCLK('1'), &zero);
}

static void on_top(avr_irq_t *irq, uint32_t value, void *p) {
    struct sim *s = p;
    (void)irq, (void)value;
    if (!avr_regbit_get(s->avr, s->timer->wgm[3]))
        s->avr->data[s->timer->r_icr] = s->avr->data[s->timer->r_icrh] = 0;
}

static uint64_t on_time(struct sim *s, uint64_t due) {
    uint64_t now = s->avr->cycle;
    return due <= now && now - due <= LATE ? due : now;
}

static void on_pulse(avr_irq_t *irq, uint32_t value, void *p) {
    struct sim *s = p;
    uint32_t k = irq->irq - TIMER_IRQ_OUT_COMP;
    uint8_t up = value & 0xff;
    if (k > 1 || up == s->high[k])
        return;
    if (up && s->rise[k] && s->avr->cycle < s->rise[k] + s->avr->frequency / PERIOD_SHORTEST)
        return;
    s->high[k] = up;
    uint64_t base = s->timer->tov_base;
    if (up) {
        s->rise[k] = on_time(s, base);
    } else {
        uint64_t fall = on_time(s, base + s->timer->comp[k].comp_cycles);
        PUSH(s->pulses, (struct pulse){s->rise[k], (uint32_t)(fall - s->rise[k]), k});
    }
}

static void on_byte(avr_irq_t *irq, uint32_t value, void *p) {
    struct sim *s = p;
    (void)irq;
    PUSH(s->from_avr, (struct byte){s->avr->cycle, value & 0xff});
}

static void on_interrupt(avr_irq_t *irq, uint32_t value, void *p) {
    struct sim *s = p;
    if (value & 0xff) {
        if (s->watch_entries && s->depth < DEPTH) {
            PUSH(s->entries, (struct entry){s->avr->cycle, 0, irq->irq >> 8});
            s->open[s->depth++] = s->entries.n - 1;
        }
        s->avr->cycle += s->entry_cycles;
    } else if (s->depth) {
        s->entries.at[s->open[--s->depth]].leave = s->avr->cycle;
    }
}

static avr_cycle_count_t on_edge(avr_t *avr, avr_cycle_count_t when, void *p) {
    struct sim *s = p;
    (void)when;
    while (s->edges.first < s->edges.n && s->edges.at[s->edges.first].cycle <= avr->cycle) {
        struct edge e = s->edges.at[s->edges.first++];
        if (!s->driven[e.pin] || s->level[e.pin] != e.level) /* a level that does not change must not be raised */
            avr_raise_irq(s->pin[e.pin], e.level);
        s->driven[e.pin] = 1;
        s->level[e.pin] = e.level;
    }
    return s->edges.first < s->edges.n ? s->edges.at[s->edges.first].cycle : 0;
}

static avr_cycle_count_t on_line(avr_t *avr, avr_cycle_count_t when, void *p) { /* one byte from the host */
    struct sim *s = p;
    struct byte b = s->to_avr.at[s->to_avr.first];
    if (avr->cycle < b.cycle)
        return b.cycle;
    s->to_avr.first++;
    avr_raise_irq(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT), b.value);
    if (s->to_avr.first == s->to_avr.n)
        return 0;
    uint64_t next = s->to_avr.at[s->to_avr.first].cycle;
    return next > when + s->byte_cycles ? next : when + s->byte_cycles;
}

static avr_cycle_count_t on_stop(avr_t *avr, avr_cycle_count_t when, void *p) {
    (void)avr;
    ((struct sim *)p)->stop = 1;
    return when + 1; /* until cancelled: else a sleeping core would go on to the timer after this one at once */
}

static void at(struct sim *s, uint64_t cycle, avr_cycle_timer_t call) {
    uint64_t now = s->avr->cycle;
    avr_cycle_timer_cancel(s->avr, call, s);
    avr_cycle_timer_register(s->avr, cycle > now ? cycle - now : 1, call, s);
}

static void set_up(struct sim *s) { /* what a reset takes away */
    avr_t *avr = s->avr;
    uint32_t flags = 0;
    avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
    for (int k = 0; k < 8; k++)
        avr_extint_set_strict_lvl_trig(avr, k, 0);
    for (int k = 0; k < PINS; k++)
        if (s->driven[k])
            avr_raise_irq(s->pin[k], s->level[k]);
    for (int k = 0; k < ADC_INPUTS; k++)
        avr_raise_irq(avr_io_getirq(avr, AVR_IOCTL_ADC_GETIRQ, ADC_IRQ_ADC0 + k), s->adc[k]);
    s->high[0] = s->high[1] = 0;
    s->depth = 0;
    if (s->edges.first < s->edges.n)
        at(s, s->edges.at[s->edges.first].cycle, on_edge);
    if (s->to_avr.first < s->to_avr.n)
        at(s, s->to_avr.at[s->to_avr.first].cycle, on_line);
}

struct sim *sim_new(const char *elf, const char *mcu, uint32_t hz, uint32_t entry_cycles, uint32_t baud) {
    elf_firmware_t firmware;
    memset(&firmware, 0, sizeof firmware);
    avr_global_logger_set(no_log);
    avr_t *avr = avr_make_mcu_by_name(mcu);
    if (!avr || elf_read_firmware(elf, &firmware))
        return NULL;
    strcpy(firmware.mmcu, mcu);
    firmware.frequency = hz;
    firmware.vcc = firmware.avcc = firmware.aref = 5000;
    struct sim *s = calloc(1, sizeof *s);
    s->avr = avr;
    s->entry_cycles = entry_cycles;
    s->byte_cycles = 10 * hz / baud;
    avr_init(avr);
    avr->custom.data = s;
    s->core_reset = avr->reset;
    avr->reset = on_reset;
    avr->sleep = no_sleep;
    avr_load_firmware(avr, &firmware);
    for (avr_io_t *io = avr->io_port; io; io = io->next) {
        if (strcmp(io->kind, "timer") || ((avr_timer_t *)io)->name != '1')
            continue;
        avr_timer_t *timer = s->timer = (avr_timer_t *)io;
        avr_irq_register_notify(avr_iomem_getirq(avr, timer->r_icr, "icr", AVR_IOMEM_IRQ_ALL), on_top, s);
        timer->wgm_op[14] = (avr_timer_wgm_t)AVR_TIMER_WGM_ICFASTPWM();
        for (int k = 0; k < 2; k++)
            avr_irq_register_notify(avr_iomem_getirq(avr, timer->comp[k].r_ocr, "ocr", AVR_IOMEM_IRQ_ALL), on_width, avr);
    }
    for (int k = 0; k < avr->interrupts.vector_count; k++) {
        avr_irq_register_notify(avr->interrupts.vector[k]->irq + AVR_INT_IRQ_RUNNING, on_interrupt, s);
    }
    for (int k = 0; k < 2; k++)
        avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_TIMER_GETIRQ('1'), TIMER_IRQ_OUT_COMP + k), on_pulse, s);
    avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), on_byte, s);
    for (int k = 0; k < PINS; k++)
        s->pin[k] = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ('D'), k);
    set_up(s);
    return s;
}

void sim_free(struct sim *s) {
    avr_terminate(s->avr);
    free(s->edges.at), free(s->to_avr.at), free(s->from_avr.at), free(s->pulses.at), free(s->entries.at);
    free(s);
}

uint64_t sim_cycle(struct sim *s) { return s->avr->cycle; }
int sim_resets(struct sim *s) { return s->resets; }
uint8_t sim_data(struct sim *s, uint32_t address) { return s->avr->data[address]; }
void sim_watch_entries(struct sim *s, int on) { s->watch_entries = on; }

void sim_adc(struct sim *s, uint32_t input, uint32_t millivolts) {
    s->adc[input] = millivolts;
    avr_raise_irq(avr_io_getirq(s->avr, AVR_IOCTL_ADC_GETIRQ, ADC_IRQ_ADC0 + input), millivolts);
}

/* Edges have to come in order of time. */
void sim_edges(struct sim *s, size_t n, const uint64_t *cycle, const uint8_t *pin, const uint8_t *level) {
    for (size_t k = 0; k < n; k++)
        PUSH(s->edges, (struct edge){cycle[k], pin[k], level[k]});
    if (s->edges.first < s->edges.n)
        at(s, s->edges.at[s->edges.first].cycle, on_edge);
}

void sim_send(struct sim *s, size_t n, const uint8_t *bytes) {
    int idle = s->to_avr.first == s->to_avr.n;
    for (size_t k = 0; k < n; k++)
        PUSH(s->to_avr, (struct byte){s->avr->cycle + s->byte_cycles, bytes[k]});
    if (idle && n)
        at(s, s->avr->cycle + s->byte_cycles, on_line);
}

int sim_run(struct sim *s, uint64_t until) { /* nonzero: the core has crashed or is done */
    s->stop = 0;
    if (s->avr->cycle >= until)
        return 0;
    at(s, until, on_stop);
    while (!s->stop) {
        int state = avr_run(s->avr);
        if (state == cpu_Done || state == cpu_Crashed)
            return state;
        if (s->reset_seen) {
            s->reset_seen = 0;
            s->resets++;
            set_up(s);
            if (s->avr->cycle >= until)
                break;
            at(s, until, on_stop);
        }
    }
    avr_cycle_timer_cancel(s->avr, on_stop, s);
    return 0;
}

size_t sim_receive(struct sim *s, size_t most, uint8_t *value, uint64_t *cycle) {
    size_t n = 0;
    for (; n < most && s->from_avr.first < s->from_avr.n; n++) {
        struct byte b = s->from_avr.at[s->from_avr.first++];
        value[n] = b.value;
        cycle[n] = b.cycle;
    }
    return n;
}

size_t sim_pulses(struct sim *s, size_t most, uint64_t *rise, uint32_t *cycles, uint8_t *output) {
    size_t n = 0;
    for (; n < most && s->pulses.first < s->pulses.n; n++) {
        struct pulse p = s->pulses.at[s->pulses.first++];
        rise[n] = p.rise;
        cycles[n] = p.cycles;
        output[n] = (uint8_t)p.output;
    }
    return n;
}

/* Interrupts that have ended, up to the first that has not. */
size_t sim_entries(struct sim *s, size_t most, uint64_t *enter, uint64_t *leave, uint8_t *vector) {
    size_t n = 0;
    for (; n < most && s->entries.first < s->entries.n && s->entries.at[s->entries.first].leave; n++) {
        struct entry e = s->entries.at[s->entries.first++];
        enter[n] = e.enter;
        leave[n] = e.leave;
        vector[n] = (uint8_t)e.vector;
    }
    return n;
}
