/* Frame rate and time in a corner of the picture. */
#include "engine_internal.h"

#include <math.h>
#include <stdio.h>

#define RATE_NS 500000000u /* the time that is measured; a shorter one could not be read */
#define RATE_EDGE 8.0f     /* pixels from the picture's edges */
#define RATE_LONG                                                                                                      \
	"100.0 frames/s   100.0 ms   longest 100.0 ms" /* so that its place does not change with the numbers */

void engine_rate_add(engine_rate *rate, uint64_t now_ns, double frame_ms)
{
	if (rate->since_ns == 0) {
		rate->since_ns = now_ns;
		return; /* the first frame makes what the others find made */
	}
	rate->frames++;
	rate->sum_ms += frame_ms;
	rate->longest_ms = fmax(rate->longest_ms, frame_ms);
	uint64_t passed = now_ns - rate->since_ns;
	if (passed < RATE_NS && rate->rate > 0.0f)
		return;
	rate->rate = (float)(rate->frames / ((double)passed * 1e-9));
	rate->ms = (float)(rate->sum_ms / rate->frames);
	rate->longest = (float)rate->longest_ms;
	if (passed < RATE_NS)
		return; /* the first number, so that there is one at once */
	rate->since_ns = now_ns;
	rate->frames = 0;
	rate->sum_ms = rate->longest_ms = 0.0;
}

void engine_rate_draw(const engine_rate *rate, stilb_ui *ui, stilb_ui_rect caption, const stilb_ui_rect *places,
                      uint32_t count)
{
	const stilb_ui_style *style = stilb_ui_style_get(ui);
	const stilb_ui_font *font = stilb_ui_font_get(ui, STILB_UI_TEXT_NORMAL);
	stilb_ui_draw_list *list = stilb_ui_list(ui);
	char text[96];
	if (rate->rate <= 0.0f)
		return;
	snprintf(text, sizeof text, "%.1f frames/s   %.1f ms   longest %.1f ms", (double)rate->rate, (double)rate->ms,
	         (double)rate->longest);
	float width = ceilf(stilb_ui_text_width(font, text)) + 2.0f * style->margin;
	float most = fmaxf(width, stilb_ui_text_width(font, RATE_LONG) + 2.0f * style->margin);
	bool lower = !stilb_ui_is_empty(caption) && caption.x0 < 2.0f * RATE_EDGE + most;
	float top = lower ? caption.y1 + RATE_EDGE : RATE_EDGE;
	stilb_ui_rect place = {RATE_EDGE, top, RATE_EDGE + width, top + style->control_height};
	for (uint32_t i = 0; i < count; i++)
		if (places[i].x0 < place.x1 && places[i].y0 < place.y1 && !stilb_ui_is_empty(places[i]))
			return;
	stilb_ui_draw_rounded(list, place, style->radius, style->panel);
	stilb_ui_draw_rounded_outline(list, place, style->radius, 1.0f, style->panel_border);
	stilb_ui_draw_text(list, font, stilb_ui_inset(place, style->margin), STILB_UI_ALIGN_LEFT, style->text, text);
}
