// The sketch is in main.c: it has its own main(), so that the Arduino core is not linked.
// Do not call millis(), delay(), Serial or analogWrite() here: timer 0 does not run, timer 1 makes the pulses and the tick.
