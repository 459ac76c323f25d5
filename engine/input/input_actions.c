#include "input/input_actions.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

#define ACTION_KEYS (sizeof((stilb_input_action *)0)->keys / sizeof(stilb_window_key))
#define ACTION_BUTTONS 0xffffu /* the bits of stilb_input_action.pad that are buttons */
#define HELP_LISTED 4u         /* keys of a line that are all named; of more, the first and the last */

static_assert(STILB_INPUT_BUTTON_COUNT <= 16 && STILB_INPUT_AXIS_COUNT <= 16, "bits of stilb_input_action.pad");

/* ---- names ------------------------------------------------------------------------------------------------------- */

const char *stilb_input_key_name(stilb_window_key key)
{
	static const char *const names[STILB_WINDOW_KEY_COUNT] = {
		[STILB_WINDOW_KEY_F1] = "F1",
		[STILB_WINDOW_KEY_F2] = "F2",
		[STILB_WINDOW_KEY_F3] = "F3",
		[STILB_WINDOW_KEY_F4] = "F4",
		[STILB_WINDOW_KEY_F5] = "F5",
		[STILB_WINDOW_KEY_F6] = "F6",
		[STILB_WINDOW_KEY_F7] = "F7",
		[STILB_WINDOW_KEY_F8] = "F8",
		[STILB_WINDOW_KEY_F9] = "F9",
		[STILB_WINDOW_KEY_F10] = "F10",
		[STILB_WINDOW_KEY_F11] = "F11",
		[STILB_WINDOW_KEY_F12] = "F12",
		[STILB_WINDOW_KEY_SHIFT] = "Shift",
		[STILB_WINDOW_KEY_CONTROL] = "Ctrl",
		[STILB_WINDOW_KEY_SPACE] = "Space",
		[STILB_WINDOW_KEY_TAB] = "Tab",
		[STILB_WINDOW_KEY_ENTER] = "Enter",
		[STILB_WINDOW_KEY_LEFT] = "Left",
		[STILB_WINDOW_KEY_RIGHT] = "Right",
		[STILB_WINDOW_KEY_UP] = "Up",
		[STILB_WINDOW_KEY_DOWN] = "Down",
		[STILB_WINDOW_KEY_PAGE_UP] = "Page Up",
		[STILB_WINDOW_KEY_PAGE_DOWN] = "Page Down",
		[STILB_WINDOW_KEY_HOME] = "Home",
		[STILB_WINDOW_KEY_END] = "End",
		[STILB_WINDOW_KEY_INSERT] = "Insert",
		[STILB_WINDOW_KEY_DELETE] = "Delete",
		[STILB_WINDOW_KEY_BACKSPACE] = "Backspace",
		[STILB_WINDOW_KEY_ESCAPE] = "Esc",
	};
	static const char letters[] = "A\0B\0C\0D\0E\0F\0G\0H\0I\0J\0K\0L\0M\0N\0O\0P\0Q\0R\0S\0T\0U\0V\0W\0X\0Y\0Z\0"
								  "0\0001\0002\0003\0004\0005\0006\0007\0008\0009";
	STILB_ASSERT((unsigned)key < STILB_WINDOW_KEY_COUNT);
	if (key >= STILB_WINDOW_KEY_A && key <= STILB_WINDOW_KEY_9)
		return &letters[(size_t)2 * (key - STILB_WINDOW_KEY_A)];
	return key == STILB_WINDOW_KEY_NONE ? "" : names[key];
}

/* The name of each bit of stilb_input_action.pad; a bit without one is named together with the bit before. */
static const char *const pad_names[32] = {
	[STILB_INPUT_SOUTH] = "A/cross",
	[STILB_INPUT_EAST] = "B/circle",
	[STILB_INPUT_WEST] = "X/square",
	[STILB_INPUT_NORTH] = "Y/triangle",
	[STILB_INPUT_LEFT_SHOULDER] = "left shoulder",
	[STILB_INPUT_RIGHT_SHOULDER] = "right shoulder",
	[STILB_INPUT_BACK] = "view/share",
	[STILB_INPUT_START] = "menu/options",
	[STILB_INPUT_GUIDE] = "guide",
	[STILB_INPUT_LEFT_STICK] = "left stick's click",
	[STILB_INPUT_RIGHT_STICK] = "right stick's click",
	[STILB_INPUT_UP] = "d-pad up",
	[STILB_INPUT_DOWN] = "d-pad down",
	[STILB_INPUT_LEFT] = "d-pad left",
	[STILB_INPUT_RIGHT] = "d-pad right",
	[STILB_INPUT_EXTRA] = "extra",
	[16 + STILB_INPUT_LEFT_X] = "left stick",
	[16 + STILB_INPUT_RIGHT_X] = "right stick",
	[16 + STILB_INPUT_LEFT_TRIGGER] = "left trigger",
	[16 + STILB_INPUT_RIGHT_TRIGGER] = "right trigger",
};

static const char *const mouse_names[] = {"drag",         "middle drag", "right drag",  "wheel",
                                          "dropped file", "click",       "double click"};
#define MOUSE_NAMES (sizeof mouse_names / sizeof *mouse_names)

/* ---- the table --------------------------------------------------------------------------------------------------- */

stilb_input_table stilb_input_table_camera(void)
{
	static const stilb_input_action camera[STILB_INPUT_ACTIONS] = {
		[STILB_INPUT_FORWARD] = {"fly", STILB_INPUT_HELD, .keys = {STILB_WINDOW_KEY_W}, .main = true, .help = "fly",
	                             .pad = STILB_INPUT_PAD_AXIS(LEFT_X) | STILB_INPUT_PAD_AXIS(LEFT_Y)},
		[STILB_INPUT_LEFTWARD] = {"fly left", STILB_INPUT_HELD, .keys = {STILB_WINDOW_KEY_A}, .help = "fly"},
		[STILB_INPUT_BACKWARD] = {"fly back", STILB_INPUT_HELD, .keys = {STILB_WINDOW_KEY_S}, .help = "fly"},
		[STILB_INPUT_RIGHTWARD] = {"fly right", STILB_INPUT_HELD, .keys = {STILB_WINDOW_KEY_D}, .help = "fly"},
		[STILB_INPUT_DOWNWARD] = {"fly down", STILB_INPUT_HELD, .keys = {STILB_WINDOW_KEY_Q}, .help = "fly down, up",
	                              .pad = STILB_INPUT_PAD(LEFT_SHOULDER)},
		[STILB_INPUT_UPWARD] = {"fly up", STILB_INPUT_HELD, .keys = {STILB_WINDOW_KEY_E}, .help = "fly down, up",
	                            .pad = STILB_INPUT_PAD(RIGHT_SHOULDER)},
		[STILB_INPUT_FASTER] = {"faster", STILB_INPUT_HELD, .keys = {STILB_WINDOW_KEY_SHIFT}, .help = "fly faster"},
		[STILB_INPUT_SPEED] = {"speed", STILB_INPUT_MOTION, .help = "fly slower, faster",
	                           .pad = STILB_INPUT_PAD_AXIS(LEFT_TRIGGER) | STILB_INPUT_PAD_AXIS(RIGHT_TRIGGER)},
		[STILB_INPUT_LOOK] = {"look", STILB_INPUT_MOTION, .mouse = STILB_INPUT_MOUSE_RIGHT, .help = "look around",
	                          .pad = STILB_INPUT_PAD_AXIS(RIGHT_X) | STILB_INPUT_PAD_AXIS(RIGHT_Y)},
	};
	stilb_input_table table = {.count = STILB_INPUT_ACTIONS};
	memcpy(table.rows, camera, sizeof camera);
	return table;
}

stilb_input_table stilb_input_table_plain(void)
{
	stilb_input_table table = stilb_input_table_camera();
	for (uint32_t row = 0; row < table.count; row++)
		table.rows[row] = (stilb_input_action){.name = "", .kind = table.rows[row].kind};
	return table;
}

stilb_input_table stilb_input_table_panels(void)
{
#define PANEL_ROW(row) [STILB_INPUT_PANEL_##row - STILB_INPUT_ACTIONS]
	static const stilb_input_action panels[STILB_INPUT_PANEL_ACTIONS - STILB_INPUT_ACTIONS] = {
		PANEL_ROW(NEXT) = {"next", STILB_INPUT_REPEAT, .keys = {STILB_WINDOW_KEY_TAB},
	                       .help = "next part of the panel; with Shift the one before"},
		PANEL_ROW(ENTER) = {"press", STILB_INPUT_REPEAT, .keys = {STILB_WINDOW_KEY_ENTER}, .help = "press it"},
		PANEL_ROW(SPACE) = {"press it", STILB_INPUT_REPEAT, .keys = {STILB_WINDOW_KEY_SPACE}, .help = "press it"},
		PANEL_ROW(LEAVE) = {"leave", STILB_INPUT_REPEAT, .keys = {STILB_WINDOW_KEY_ESCAPE}, .help = "leave the panel"},
		PANEL_ROW(LEFT) = {"left", STILB_INPUT_REPEAT, .keys = {STILB_WINDOW_KEY_LEFT}, .help = "go along it"},
		PANEL_ROW(RIGHT) = {"right", STILB_INPUT_REPEAT, .keys = {STILB_WINDOW_KEY_RIGHT}, .help = "go along it"},
		PANEL_ROW(UP) = {"up", STILB_INPUT_REPEAT, .keys = {STILB_WINDOW_KEY_UP}, .help = "go along it"},
		PANEL_ROW(DOWN) = {"down", STILB_INPUT_REPEAT, .keys = {STILB_WINDOW_KEY_DOWN}, .help = "go along it"},
		PANEL_ROW(BACK) = {"back", STILB_INPUT_HELD, .keys = {STILB_WINDOW_KEY_SHIFT}},
	};
#undef PANEL_ROW
	stilb_input_table table = stilb_input_table_plain();
	stilb_result result = stilb_input_table_add(&table, panels, sizeof panels / sizeof *panels);
	STILB_ASSERT(result == STILB_OK);
	(void)result;
	return table;
}

/* The character that a key types on every layout that matters here: of letters and digits; else 0. */
static int action_key_types(stilb_window_key key)
{
	return key >= STILB_WINDOW_KEY_A && key <= STILB_WINDOW_KEY_9 ? stilb_input_key_name(key)[0] : 0;
}

/* Writes into name what both rows have, or returns false. */
static bool action_shared(const stilb_input_action *a, const stilb_input_action *b, char name[static 32])
{
	for (size_t i = 0; i < ACTION_KEYS; i++)
		for (size_t k = 0; k < ACTION_KEYS; k++)
			if (a->keys[i] != STILB_WINDOW_KEY_NONE && a->keys[i] == b->keys[k]) {
				snprintf(name, 32, "%s", stilb_input_key_name(a->keys[i]));
				return true;
			}
	for (const char *c = a->typed; c && *c; c++) {
		bool key = false;
		for (size_t k = 0; k < ACTION_KEYS; k++)
			key = key || toupper((unsigned char)*c) == action_key_types(b->keys[k]);
		if (key || (b->typed && strchr(b->typed, *c))) {
			snprintf(name, 32, "%c", *c);
			return true;
		}
	}
	for (uint32_t bit = 0; bit < 32; bit++)
		if (a->pad & b->pad & 1u << bit) {
			snprintf(name, 32, "%s", pad_names[bit] ? pad_names[bit] : pad_names[bit - 1]);
			return true;
		}
	for (uint32_t bit = 0; bit < MOUSE_NAMES; bit++)
		if (a->mouse & b->mouse & 1u << bit) {
			snprintf(name, 32, "%s", mouse_names[bit]);
			return true;
		}
	return false;
}

/* Refuses a row that says by itself what cannot be. */
static stilb_result action_check(const stilb_input_action *row)
{
	STILB_ASSERT((unsigned)row->kind <= STILB_INPUT_MOTION);
	if (!row->name || !row->name[0])
		return stilb_fail(STILB_ERROR_ARGUMENT, "an action of the table has no name");
	char shared[32];
	bool has_keys = row->keys[0] != STILB_WINDOW_KEY_NONE || (row->pad & ACTION_BUTTONS) != 0;
	for (const char *c = row->typed; c && *c; c++)
		if (!isprint((unsigned char)*c))
			return stilb_fail(STILB_ERROR_ARGUMENT, "action '%s' is typed by a character that is not ASCII", row->name);
	if (row->kind == STILB_INPUT_HELD && row->typed)
		return stilb_fail(STILB_ERROR_ARGUMENT,
		                  "action '%s' is held, which typed characters cannot be; give it a key or another kind",
		                  row->name);
	if (row->kind != STILB_INPUT_MOTION && row->mouse != 0)
		return stilb_fail(STILB_ERROR_ARGUMENT, "action '%s' has a part of the mouse; only a motion can", row->name);
	if (row->kind == STILB_INPUT_MOTION && (has_keys || row->typed))
		return stilb_fail(STILB_ERROR_ARGUMENT, "action '%s' is a motion, which has no keys and buttons", row->name);
	stilb_input_action types = {.typed = row->typed}, keys = *row;
	keys.typed = NULL;
	if (action_shared(&types, &keys, shared))
		return stilb_fail(STILB_ERROR_ARGUMENT, "action '%s' has '%s' as a key and as a character", row->name, shared);
	return STILB_OK;
}

stilb_result stilb_input_table_add(stilb_input_table *table, const stilb_input_action *rows, uint32_t count)
{
	STILB_ASSERT(table && (rows || count == 0));
	STILB_ASSERT(table->count <= STILB_INPUT_ACTIONS_MAX);
	if (count > STILB_INPUT_ACTIONS_MAX - table->count)
		return stilb_fail(STILB_ERROR_ARGUMENT, "%u actions are more than %u, with the %u that there are", count,
		                  STILB_INPUT_ACTIONS_MAX, table->count);
	for (uint32_t i = 0; i < count; i++) {
		char shared[32];
		stilb_result result = action_check(&rows[i]);
		for (uint32_t k = 0; k < table->count + i && result == STILB_OK; k++) {
			const stilb_input_action *other = k < table->count ? &table->rows[k] : &rows[k - table->count];
			if (strcmp(other->name, rows[i].name) == 0)
				result = stilb_fail(STILB_ERROR_ARGUMENT, "two actions are named '%s'", rows[i].name);
			else if (action_shared(other, &rows[i], shared) || action_shared(&rows[i], other, shared))
				result = stilb_fail(STILB_ERROR_ARGUMENT, "actions '%s' and '%s' both have '%s'; give one another key",
				                    other->name, rows[i].name, shared);
		}
		if (result != STILB_OK)
			return result;
	}
	table->newest = table->count;
	for (uint32_t i = 0; i < count; i++)
		table->rows[table->count++] = rows[i];
	return STILB_OK;
}

/* ---- help -------------------------------------------------------------------------------------------------------- */

/* A list of names that is being written. */
typedef struct help_list {
	char *text;
	size_t size;
	uint32_t count; /* names that were added */
	size_t first;   /* length of the text with the first name alone */
	char last[16];  /* the name added last */
} help_list;

static void help_add(help_list *list, const char *name)
{
	size_t length = strlen(list->text);
	snprintf(list->text + length, list->size - length, "%s%s", length > 0 ? ", " : "", name);
	snprintf(list->last, sizeof list->last, "%s", name);
	if (list->count++ == 0)
		list->first = strlen(list->text);
}

/* Of a list that is too long, leaves the first and the last name. */
static void help_shorten(help_list *list)
{
	if (list->count > HELP_LISTED)
		snprintf(list->text + list->first, list->size - list->first, " ... %s", list->last);
}

/* Adds the names of the row's parts to the line. */
static void help_add_row(const stilb_input_action *row, help_list *keys, help_list *mouse, help_list *pad)
{
	for (size_t i = 0; i < ACTION_KEYS; i++)
		if (row->keys[i] != STILB_WINDOW_KEY_NONE)
			help_add(keys, stilb_input_key_name(row->keys[i]));
	if (row->typed && row->typed[0])
		help_add(keys, (char[]){row->typed[0], '\0'});
	for (uint32_t bit = 0; bit < MOUSE_NAMES; bit++)
		if (row->mouse & 1u << bit)
			help_add(mouse, mouse_names[bit]);
	for (uint32_t bit = 0; bit < 32; bit++)
		if (row->pad & 1u << bit && pad_names[bit])
			help_add(pad, pad_names[bit]);
}

/* The row at this place of the help's order, in which the rows that were added last come first. */
static const stilb_input_action *help_row(const stilb_input_table *table, uint32_t place)
{
	uint32_t row = place + table->newest;
	return &table->rows[row < table->count ? row : row - table->count];
}

bool stilb_input_help_next(const stilb_input_table *table, uint32_t *next, stilb_input_help *line)
{
	STILB_ASSERT(table && next && line);
	STILB_ASSERT(table->count >= STILB_INPUT_ACTIONS && table->count <= STILB_INPUT_ACTIONS_MAX);
	uint32_t place = *next;
	while (place < table->count && !help_row(table, place)->help)
		place++;
	*next = place;
	if (place >= table->count)
		return false;
	const stilb_input_action *first = help_row(table, place);
	*line = (stilb_input_help){.name = first->name, .help = first->help, .row = (uint32_t)(first - table->rows)};
	help_list keys = {line->keys, sizeof line->keys, 0, 0, ""};
	help_list mouse = {line->mouse, sizeof line->mouse, 0, 0, ""};
	help_list pad = {line->pad, sizeof line->pad, 0, 0, ""};
	for (; place < table->count; place++) {
		const stilb_input_action *row = help_row(table, place);
		if (!row->help || strcmp(row->help, first->help) != 0)
			break;
		line->main |= row->main;
		help_add_row(row, &keys, &mouse, &pad);
	}
	help_shorten(&keys);
	*next = place;
	return true;
}
