/* Output reports that make a pad rumble. Sources: Linux, drivers/hid/hid-playstation.c (DualShock 4, DualSense),
 * hid-microsoft.c (Xbox), hid-nintendo.c (Switch Pro). */
#include "input/hid/input_layout.h"

#include <math.h>
#include <string.h>

/* A strength in [0, 1] as a whole number in 0..most. */
static uint8_t scaled(float strength, float most)
{
	return (uint8_t)(fminf(fmaxf(strength, 0.0f), 1.0f) * most + 0.5f);
}

/* Fills the last four of size bytes with the CRC-32 of the Bluetooth header 0xa2 (HID data, output) and all bytes
 * before them. Returns size. */
static size_t with_crc(uint8_t *report, size_t size)
{
	STILB_ASSERT(size > 4 && size <= STILB_INPUT_OUTPUT_MAX);
	uint8_t bluetooth_output = 0xa2;
	uint32_t crc = stilb_input_crc32(stilb_input_crc32(0, &bluetooth_output, 1), report, size - 4);
	for (size_t i = 0; i < 4; i++)
		report[size - 4 + i] = (uint8_t)(crc >> 8 * i);
	return size;
}

/* at[0]: which parts the report sets (the motors, not the light bar); at[3]: light motor; at[4]: heavy motor. */
static void ds4_motors(uint8_t *at, float heavy, float light)
{
	at[0] = 0x01;
	at[3] = scaled(light, 255.0f);
	at[4] = scaled(heavy, 255.0f);
}

/* at[0]: which parts the report sets (the motors, in the mode compatible with a DualShock 4, in place of audio
 * haptics); at[2]: light motor; at[3]: heavy motor. */
static void dualsense_motors(uint8_t *at, float heavy, float light)
{
	at[0] = 0x03;
	at[2] = scaled(light, 255.0f);
	at[3] = scaled(heavy, 255.0f);
}

/* Sets the two main motors, not those in the triggers, in per cent, for 255 x 10 ms repeated 255 times: practically
 * until the next report. */
static void xbox_motors(uint8_t *report, float heavy, float light)
{
	report[0] = 0x03;
	report[1] = 0x03;
	report[4] = scaled(heavy, 100.0f);
	report[5] = scaled(light, 100.0f);
	report[6] = 0xff;
	report[8] = 0xff;
}

/* The pad is told an amplitude by its number in a table of 101 steps. Returns the step in 0..100 whose amplitude is
 * closest to `strength`: the table of hid-nintendo in closed form. */
static uint32_t switch_amplitude(float strength)
{
	float amplitude = fminf(fmaxf(strength, 0.0f), 1.0f);
	if (amplitude < 0.01f)
		return 0;
	float step = amplitude < 0.117f  ? 4.0f * log2f(amplitude / 0.01f) + 1.0f
	             : amplitude < 0.23f ? 16.0f * log2f(17.0f * amplitude)
	                                 : 32.0f * log2f(8.7f * amplitude);
	return (uint32_t)(fminf(step, 100.0f) + 0.5f);
}

/* Four bytes for one side's motor, which vibrates at 320 Hz and at 160 Hz at once, here with the same amplitude; with
 * amplitude 0 they are 00 01 40 40. */
static void switch_motor(uint8_t at[4], float strength)
{
	uint32_t step = switch_amplitude(strength);
	STILB_ASSERT(step <= 100);
	at[0] = 0x00;
	at[1] = (uint8_t)(0x01 + 2 * step);
	at[2] = (uint8_t)(0x40 + (step & 1) * 0x80);
	at[3] = (uint8_t)(0x40 + step / 2);
}

size_t stilb_input_rumble_report(const stilb_input_layout *layout, float heavy, float light, uint32_t sequence,
                                 uint8_t report[STILB_INPUT_OUTPUT_MAX])
{
	STILB_ASSERT(layout && report);
	memset(report, 0, STILB_INPUT_OUTPUT_MAX);
	switch (layout->rumble) {
	case STILB_INPUT_RUMBLE_DS4_USB:
		report[0] = 0x05;
		ds4_motors(report + 1, heavy, light);
		return 32;
	case STILB_INPUT_RUMBLE_DS4_BLUETOOTH:
		report[0] = 0x11;
		report[1] = 0xc0; /* bit 7: HID, bit 6: there is a CRC */
		ds4_motors(report + 3, heavy, light);
		return with_crc(report, 78);
	case STILB_INPUT_RUMBLE_DUALSENSE_USB:
		report[0] = 0x02;
		dualsense_motors(report + 1, heavy, light);
		return 48;
	case STILB_INPUT_RUMBLE_DUALSENSE_BLUETOOTH:
		report[0] = 0x31;
		report[1] = (uint8_t)(sequence << 4);
		report[2] = 0x10; /* a constant, as in hid-playstation */
		dualsense_motors(report + 3, heavy, light);
		return with_crc(report, 78);
	case STILB_INPUT_RUMBLE_XBOX_BLUETOOTH:
		xbox_motors(report, heavy, light);
		return 9;
	case STILB_INPUT_RUMBLE_SWITCH:
		report[0] = 0x10;
		report[1] = sequence & 0x0f;
		switch_motor(report + 2, heavy);
		switch_motor(report + 6, light);
		return 10;
	case STILB_INPUT_RUMBLE_NONE:
		break;
	}
	return 0;
}
