/*
 * gi_picture: what a picture's file is made of, from a render or from parts of one.
 */
#ifndef GI_PICTURE_H
#define GI_PICTURE_H

#include "gi/film/gi_film.h"

typedef struct gi_picture {
	const stilb_gi_settings *settings;
	const gi_film *film;
	const char *surroundings, *isa; /* in words, for the file */
	const stilb_gi_grade *grade;    /* of what is shown; NULL: none */
	bool transparent;               /* nothing is behind the models: the file has alpha */
} gi_picture;

/* The body of stilb_gi_render_save. */
stilb_result gi_picture_save(const gi_picture *picture, const char *path);

#endif
