/* The cases of the suite `input`: X(NAME, TITLE, METRICS) with METRICS a list of bench_metric in bench_input.c. */
#ifndef INPUT_CASES_H
#define INPUT_CASES_H

#define INPUT_CASES(X)                                                                                                 \
	X("parse", "report descriptors: a joystick's of 625 bytes, a pad's of 507, the fullest of 4096", parse)            \
	X("find", "the layout of a pad: by the table, by its descriptor's fields", find)                                   \
	X("decode", "a report of 64 bytes by USB; one of 78 by Bluetooth with its CRC; that CRC alone", decode)            \
	X("frame", "a frame's control with 0, 16 and 500 reports since the frame before", frame)                           \
	X("camera", "the flight over a frame of 1/60 s, with a new wish in it", camera)

#endif
