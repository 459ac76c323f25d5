#include "live_keys.h"

#include <stdio.h>
#include <string.h>

#define KEYS_COLUMN 23 /* characters of the column of keys, with the blanks around it */

static const stilb_input_action live_rows[LIVE_KEY_COUNT] = {
	[LIVE_KEY_FEWER_WORKERS] = {.name = "fewer workers",
                                .typed = "-",
                                .pad = STILB_INPUT_PAD(DOWN),
                                .help = "one worker fewer, more"},
	[LIVE_KEY_MORE_WORKERS] = {.name = "more workers",
                               .typed = "+=", /* on many layouts + is = with Shift */
                               .pad = STILB_INPUT_PAD(UP),
                               .help = "one worker fewer, more"},
};

uint32_t live_keys_number(const live_keys *keys, live_key key)
{
	return STILB_ENGINE_ACTIONS + keys->count + (uint32_t)key;
}

uint32_t live_keys_rows(const live_keys *keys, stilb_input_action rows[static STILB_INPUT_ACTIONS_MAX])
{
	STILB_ASSERT(keys->count <= STILB_INPUT_ACTIONS_MAX - LIVE_KEY_COUNT);
	for (uint32_t i = 0; i < keys->count; i++)
		rows[i] = keys->rows[i];
	memcpy(rows + keys->count, live_rows, sizeof live_rows);
	return keys->count + LIVE_KEY_COUNT;
}

void live_keys_print(const live_keys *keys)
{
	stilb_input_action rows[STILB_INPUT_ACTIONS_MAX];
	stilb_input_table table;
	stilb_engine_desc desc = {.actions = rows, .action_count = live_keys_rows(keys, rows), .saves = true};
	if (stilb_engine_table(&desc, &table) != STILB_OK) {
		stilb_log("%s", stilb_error_message());
		return;
	}
	live_keys_print_table(&table);
}

void live_keys_print_table(const stilb_input_table *table)
{
	stilb_input_help line;
	for (uint32_t next = 0; stilb_input_help_next(table, &next, &line);) {
		char names[sizeof line.keys + sizeof line.mouse + 2];
		snprintf(names, sizeof names, "%s%s%s", line.mouse, line.mouse[0] && line.keys[0] ? ", " : "", line.keys);
		printf("  %-*s%s%s%s%s\n", KEYS_COLUMN, names[0] ? names : "gamepad", line.help, line.pad[0] ? " (" : "",
		       line.pad, line.pad[0] ? ")" : "");
	}
}
