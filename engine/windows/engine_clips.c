/*
 * The animation's window: what the scene's own figure plays (scene_play.h). A line of time to drag, pause and speed,
 * and the clips of the file, of which several may play at once, each with a weight.
 */
#include "engine_internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define CLIPS_WIDTH 360.0f /* pixels, at most */
#define CLIPS_ROWS 8u      /* clips that are seen at once, at most */
#define CLIPS_BORDER 2.0f  /* pixels: the panel's border is no thicker */
#define CLIPS_LINES 4u     /* controls above the list */
#define CLIPS_SPEED 4.0f   /* of the slider at most */

/* What figure 0 plays, as the window changes it. */
typedef struct clips_plays {
	stilb_scene_play plays[STILB_SCENE_MAX_PLAYS];
	uint32_t count;
	bool changed;
} clips_plays;

static clips_plays clips_read(const stilb_scene *scene)
{
	clips_plays now = {0};
	const stilb_scene_play *plays = stilb_scene_plays_of(scene, 0, &now.count);
	if (plays)
		memcpy(now.plays, plays, now.count * sizeof *plays);
	return now;
}

/* Where a clip is among what plays; the count: it does not. */
static uint32_t clips_find(const clips_plays *now, uint32_t clip)
{
	uint32_t p = 0;
	while (p < now->count && now->plays[p].clip != clip)
		p++;
	return p;
}

/* Starts a clip, or ends it. */
static void clips_switch(clips_plays *now, uint32_t clip)
{
	uint32_t p = clips_find(now, clip);
	if (p < now->count) {
		memmove(&now->plays[p], &now->plays[p + 1], (now->count - p - 1) * sizeof *now->plays);
		now->count--;
		now->changed = true;
	} else if (now->count < STILB_SCENE_MAX_PLAYS) {
		now->plays[now->count] = stilb_scene_play_make(clip);
		if (now->count > 0) /* as fast as the others */
			now->plays[now->count].speed = now->plays[0].speed;
		now->count++;
		now->changed = true;
	}
}

static stilb_ui_rect clips_line(const stilb_ui_style *style, stilb_ui_rect *area)
{
	stilb_ui_rect line = stilb_ui_cut_top(area, style->control_height);
	stilb_ui_cut_top(area, style->gap);
	return line;
}

/* The first of what plays: pause, steps, its time and speed, and whether it begins anew. */
static void clips_draw_time(stilb_engine *engine, stilb_ui *ui, stilb_ui_rect *area, clips_plays *now)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	const stilb_scene *scene = engine->scene;
	stilb_scene_play *play = now->count > 0 ? &now->plays[0] : NULL;
	float duration = play ? scene->animation->clips[play->clip].duration : 0.0f, time = play ? (float)play->time : 0.0f;
	stilb_ui_rect line = clips_line(style, area);
	if (stilb_ui_slider(ui, line, "Time", &time,
	                    &(stilb_ui_slider_range){0.0f, fmaxf(duration, 1e-6f), 0.0f, "%.2f s"}) &&
	    play) {
		for (uint32_t p = 0; p < now->count; p++)
			now->plays[p].time += (double)time - play->time;
		now->changed = true;
	}
	line = clips_line(style, area);
	float third = floorf((line.x1 - line.x0 - 2.0f * style->gap) / 3.0f);
	bool paused = engine->playing.pace == 0.0f;
	if (stilb_ui_toggle(ui, stilb_ui_cut_left(&line, third), "Pause", &paused))
		engine_playing_pause(engine);
	stilb_ui_cut_left(&line, style->gap);
	if (stilb_ui_button(ui, stilb_ui_cut_left(&line, third), "< step"))
		stilb_engine_step(engine, -ENGINE_STEP);
	stilb_ui_cut_left(&line, style->gap);
	if (stilb_ui_button(ui, line, "step >"))
		stilb_engine_step(engine, ENGINE_STEP);
	line = clips_line(style, area);
	float speed = play ? play->speed : 1.0f;
	if (stilb_ui_slider(ui, line, "Speed", &speed, &(stilb_ui_slider_range){-CLIPS_SPEED, CLIPS_SPEED, 0.05f, "%.2f"}))
		for (uint32_t p = 0; p < now->count; p++) {
			now->plays[p].speed = speed;
			now->changed = true;
		}
	line = clips_line(style, area);
	bool loops = !play || play->repeat == STILB_SCENE_LOOP;
	if (stilb_ui_checkbox(ui, stilb_ui_cut_left(&line, stilb_ui_checkbox_width(ui, "Loop")), "Loop", &loops))
		for (uint32_t p = 0; p < now->count; p++) {
			now->plays[p].repeat = loops ? STILB_SCENE_LOOP : STILB_SCENE_ONCE;
			now->changed = true;
		}
}

/* The clips, each with a box that starts and ends it and, if it plays, its weight. */
static void clips_draw_list(const stilb_scene *scene, stilb_ui *ui, stilb_ui_rect area, stilb_ui_list_state *state,
                            clips_plays *now)
{
	const stilb_scene_animation *animation = scene->animation;
	stilb_ui_rows rows = stilb_ui_rows_begin(ui, area, "clips", animation->clip_count, state);
	for (uint32_t c = rows.first; c < rows.end; c++) {
		stilb_ui_rect row = stilb_ui_row(ui, &rows, c), name = row;
		uint32_t p = clips_find(now, c);
		bool plays = p < now->count;
		stilb_ui_id_push_number(ui, c);
		if (plays)
			name = stilb_ui_cut_left(&row, floorf(0.6f * (row.x1 - row.x0)));
		if (stilb_ui_checkbox(ui, name, animation->clips[c].name, &plays))
			clips_switch(now, c);
		else if (p < now->count &&
		         stilb_ui_slider(ui, row, "Weight", &now->plays[p].weight, &(stilb_ui_slider_range){0, 1, 0.01f, NULL}))
			now->changed = true;
		stilb_ui_id_pop(ui);
	}
	stilb_ui_rows_end(ui);
}

/* At first in the lower left corner, from then on wherever the user moved it. */
static void clips_place(engine_clips *clips, const stilb_ui_style *style, const stilb_ui_input *input, uint32_t count)
{
	float around = 2.0f * style->margin, row = fmaxf(style->row_height, style->control_height);
	float lines = (float)CLIPS_LINES * (style->control_height + style->gap);
	float height =
		style->title_height + around + CLIPS_BORDER + lines + row * (float)(count < CLIPS_ROWS ? count : CLIPS_ROWS);
	float width = fminf(CLIPS_WIDTH, input->width - around);
	height = fminf(height, input->height - around);
	stilb_ui_rect *place = &clips->place;
	if (stilb_ui_is_empty(*place))
		*place = (stilb_ui_rect){.x0 = style->margin, .y0 = input->height - height - style->margin};
	*place = (stilb_ui_rect){place->x0, place->y0, place->x0 + width, place->y0 + height};
}

void engine_clips_draw(stilb_engine *engine, stilb_ui *ui)
{
	engine_clips *clips = &engine->overlay.clips;
	stilb_ui_style *style = stilb_ui_style_get(ui);
	const stilb_scene *scene = engine->scene;
	uint32_t count = scene && scene->figures ? scene->animation->clip_count : 0;
	clips_place(clips, style, stilb_ui_input_get(ui), count > 0 ? count : 1);
	stilb_ui_id_push(ui, "clips");
	stilb_ui_rect area = stilb_ui_panel_begin(ui, "Animation", &clips->place, STILB_UI_PANEL_MOVABLE, &clips->open);
	if (count == 0) {
		stilb_ui_label_muted(ui, clips_line(style, &area), STILB_UI_ALIGN_LEFT, "The scene has no clips.");
	} else {
		clips_plays now = clips_read(scene);
		float usual = style->row_height;
		clips_draw_time(engine, ui, &area, &now);
		style->row_height = fmaxf(usual, style->control_height);
		clips_draw_list(scene, ui, area, &clips->list, &now);
		style->row_height = usual;
		if (now.changed && stilb_scene_set_plays(engine->scene, 0, now.plays, now.count) != STILB_OK)
			stilb_log("%s", stilb_error_message());
		if (now.changed && now.count == 0)
			stilb_scene_rest_figure(engine->scene, 0);
	}
	stilb_ui_panel_end(ui);
	stilb_ui_id_pop(ui);
}
