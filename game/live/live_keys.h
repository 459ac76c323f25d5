/*
 * live_keys: what the keys of a live command do: the rows of its table of actions, and their help. [any-thread]
 *
 *   stilb_input_action rows[STILB_INPUT_ACTIONS_MAX];
 *   desc.action_count = live_keys_rows(&keys, rows);
 *   desc.actions = rows;
 */
#ifndef STILB_LIVE_KEYS_H
#define STILB_LIVE_KEYS_H

#include "engine.h"

/* A command's own rows, which have the numbers from STILB_ENGINE_ACTIONS on. */
typedef struct live_keys {
	const stilb_input_action *rows; /* [count] */
	uint32_t count;
} live_keys;

/* The rows that all live commands have. They follow the command's: their numbers are live_keys_number's. */
typedef enum live_key { LIVE_KEY_FEWER_WORKERS, LIVE_KEY_MORE_WORKERS, LIVE_KEY_COUNT } live_key;
uint32_t live_keys_number(const live_keys *keys, live_key key);

/* Writes the command's rows and then these into rows, and returns their number. */
uint32_t live_keys_rows(const live_keys *keys, stilb_input_action rows[static STILB_INPUT_ACTIONS_MAX]);

/* Prints a line for each action on stdout: keys and mouse, what they do, the gamepad in brackets. */
void live_keys_print(const live_keys *keys);

/* As live_keys_print, of a table. */
void live_keys_print_table(const stilb_input_table *table);

#endif
