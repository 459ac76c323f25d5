/* Known answers: small .glb files, each of which shows one feature of glTF's materials or a pair of them, on a card
 * that faces the camera. Frames and rays must agree on every one. gltf_answers.c has the list. */
#ifndef GLTF_ANSWERS_H
#define GLTF_ANSWERS_H

#include <stdbool.h>
#include <stdint.h>

typedef struct gltf_answer {
	const char *name;
	const char *material;   /* JSON of material 0, without braces; textures are numbered as `pictures` lists them */
	const char *pictures;   /* a letter for each texture: see gltf_answers.c */
	const char *samplers;   /* JSON of sampler 0, which all textures use; NULL: none */
	const char *light;      /* JSON of the light's members; NULL: a directional light */
	const char *node;       /* JSON of the card's node, besides its mesh; NULL: none */
	const char *extensions; /* extensionsUsed, JSON strings; NULL: none */
	uint32_t attributes;    /* GLTF_ANSWER_... */
	const char *says;       /* a part of what opening it tells; NULL: nothing */
	bool chance;            /* rays decide by chance what is seen: they have more noise */
	bool ggx;               /* by GGX in place of Blinn and Phong's model, which is never brushed */
	bool flat;              /* rays see one colour */
	bool edges;             /* the picture has edges inside of the card, at which pixels are not compared */
} gltf_answer;

#define GLTF_ANSWER_UV1 1u       /* a second uv: turned by a quarter */
#define GLTF_ANSWER_TANGENTS 2u  /* of the file */
#define GLTF_ANSWER_COLORS 4u    /* of vertices, floats, three */
#define GLTF_ANSWER_COLORS_U8 8u /* four bytes with alpha */
#define GLTF_ANSWER_MIRRORED 16u /* the right half's uv are those of the left, mirrored */
#define GLTF_ANSWER_BEHIND 32u   /* a second, green card behind */
#define GLTF_ANSWER_BALL 64u     /* a ball in place of the card */
#define GLTF_ANSWER_BACK 128u    /* the card is seen from behind */

extern const gltf_answer gltf_answers[];
extern const uint32_t gltf_answer_count;

/* Writes an answer's file. False: it cannot be written. */
bool gltf_answer_write(const gltf_answer *answer, const char *path);

#endif
