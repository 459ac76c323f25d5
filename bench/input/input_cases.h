/* The cases of the suite `input`: X(NAME, TITLE, METRICS) with METRICS a list of bench_metric in bench_input.c. */
#ifndef INPUT_CASES_H
#define INPUT_CASES_H

#define INPUT_CASES(X)                                                                                                 \
	X("parse", "parsing a report descriptor: a joystick's (625 bytes), a pad's (507), the most fields (4096)", parse)  \
	X("find", "finding a gamepad's layout: in the table of known ones, from its descriptor's fields", find)            \
	X("decode", "decoding a report: 64 bytes by USB, 78 bytes by Bluetooth with CRC; the CRC alone", decode)           \
	X("frame", "camera control of a frame with 0, 16 and 500 new reports", frame)                                      \
	X("camera", "moving the camera by a frame of 1/60 s, with a change of input inside", camera)

#endif
