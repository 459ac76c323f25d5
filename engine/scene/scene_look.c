/* The texts in the file of a picture for display: how it shows its scene. */
#include "scene/scene_look.h"
#include "shading/shade_tonemap.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

void stilb_scene_environment_words(const stilb_scene_surroundings *surroundings, char *words, size_t size)
{
	STILB_ASSERT(surroundings && words && size > 0);
	const float *sky = surroundings->sky, *ground = surroundings->ground;
	bool map = surroundings->panorama.pixels;
	double degrees = remainder((double)surroundings->rotation * (180.0 / 3.14159265358979323846), 360.0);
	if (surroundings->name[0] || map)
		snprintf(words, size, "%.*s", (int)sizeof surroundings->name - 1,
		         surroundings->name[0] ? surroundings->name : "a panorama");
	else if (memcmp(sky, ground, sizeof surroundings->sky) == 0)
		snprintf(words, size, "%.6g,%.6g,%.6g", (double)sky[0], (double)sky[1], (double)sky[2]);
	else
		snprintf(words, size, "%.6g,%.6g,%.6g over %.6g,%.6g,%.6g", (double)sky[0], (double)sky[1], (double)sky[2],
		         (double)ground[0], (double)ground[1], (double)ground[2]);
	size_t used = strlen(words);
	if (map && fabs(degrees) >= 0.05)
		snprintf(words + used, size - used, " turned by %.4g degrees", degrees);
}

stilb_result stilb_scene_look_save(const stilb_scene_look *look, const stilb_image *image, const char *path)
{
	STILB_ASSERT(look && look->tone < SHADE_TONE_COUNT);
	char exposure[STILB_FLOAT_TEXT];
	stilb_float_text(look->exposure, exposure);
	const stilb_image_attribute texts[] = {{"stilb:exposure", exposure},
	                                       {"stilb:tone", stilb_scene_tone_names[look->tone]},
	                                       {"stilb:environment", look->environment}};
	return stilb_image_save_with(image, path, texts, sizeof texts / sizeof *texts);
}
