/*
 * scene_stream: a scene as bytes, from one process to another of the same build. What comes in is checked, so that
 * whatever the other side sent, a scene that is read is one that can be used.
 */
#ifndef STILB_SCENE_STREAM_H
#define STILB_SCENE_STREAM_H

#include "scene/scene.h"

typedef struct scene_stream {
	int file;             /* a pipe */
	uint64_t deadline_ns; /* of reading, on stilb_time_ns's clock */
	bool late, ended;     /* why a read failed: the deadline passed; the other side closed */
} scene_stream;

typedef enum scene_message_kind {
	SCENE_MESSAGE_HELLO,   /* first; its text is scene_stream_version's */
	SCENE_MESSAGE_WARNING, /* any number */
	SCENE_MESSAGE_ERROR,   /* the end */
	SCENE_MESSAGE_SCENE,   /* the end; the scene follows */
} scene_message_kind;

typedef struct scene_message {
	scene_message_kind kind;
	stilb_result result; /* of an ERROR */
	char text[500];      /* ends in 0 */
} scene_message;

/* Two processes whose texts differ do not understand one another. */
void scene_stream_version(char text[static 64]);

bool scene_stream_write_message(int file, const scene_message *message);
bool scene_stream_read_message(scene_stream *stream, scene_message *message);

/* Models, parts, meshes, materials, textures, lights, sun, sky and camera. false: the other side is gone. */
bool scene_stream_write(int file, const stilb_scene *scene);

/* STILB_ERROR_FILE with a reason that starts without a name: the stream ended, or what it says makes no scene. */
stilb_result scene_stream_read(scene_stream *stream, stilb_scene **scene);

#endif
