/*
 * scene_stream: requests, answers, descriptors and scenes between Stilb and its import process, which are of the same
 * build. What comes in is checked, so that whatever the other side sent, a scene that is read is one that can be used.
 *
 * Stilb asks (READ_SCENE, READ_PICTURE, with the file's descriptor, or ABOUT) and listens until an end. Meanwhile the
 * import process may send warnings and ask for further files (OPEN), each of which Stilb answers with FILE before
 * anything else.
 */
#ifndef STILB_SCENE_STREAM_H
#define STILB_SCENE_STREAM_H

#include "scene/scene.h"

typedef struct scene_stream {
	int file;              /* a socket, for messages; a scene can come out of any file */
	uint64_t deadline_ns;  /* of reading, on stilb_time_ns's clock; UINT64_MAX: none */
	uint64_t limit, taken; /* bytes that may be read in all (0: any number) and were, descriptors' pictures included */
	bool late, ended, too_much; /* why a read failed: the deadline passed; the other side closed; the limit */
} scene_stream;

typedef enum scene_message_kind {
	/* from the import process */
	SCENE_MESSAGE_HELLO,   /* once, first; its text is scene_stream_version's, its flags are scene_protection's */
	SCENE_MESSAGE_WARNING, /* any number */
	SCENE_MESSAGE_OPEN,    /* asks for the file that the scene calls text */
	/* a picture's shape and the descriptor of its pixels: a scene's textures in order, or an end */
	SCENE_MESSAGE_PICTURE,
	SCENE_MESSAGE_ERROR,   /* an end: text says why, result which */
	SCENE_MESSAGE_SCENE,   /* an end; the scene follows */
	SCENE_MESSAGE_VERSION, /* the end of ABOUT: text is a library and its version, one a line */
	/* to the import process */
	SCENE_MESSAGE_FILE,         /* the answer to OPEN: a descriptor, or the reason why there is none in text */
	SCENE_MESSAGE_READ_SCENE,   /* with the file's descriptor; text is its path */
	SCENE_MESSAGE_READ_PICTURE, /* the same */
	SCENE_MESSAGE_READ_LIGHT,   /* the same, as three channels of linear floats, nothing below 0 */
	SCENE_MESSAGE_ABOUT,
} scene_message_kind;

/* What guards the import process, as flags. Without one of them it still works. */
typedef enum scene_protection {
	SCENE_PROTECTION_PRIVILEGES = 1, /* no_new_privs: no program gives it more rights */
	SCENE_PROTECTION_LANDLOCK = 2,   /* it can open no file but the system's libraries */
	SCENE_PROTECTION_SECCOMP = 4,    /* it can use only those system calls that decoding needs */
	SCENE_PROTECTION_LIMITS = 8,     /* of memory, file size, descriptors and time */
} scene_protection;

#define SCENE_MESSAGE_TEXT 4096 /* a path has room */

typedef struct scene_message {
	scene_message_kind kind;
	stilb_result result;              /* of ERROR */
	uint32_t flags;                   /* of HELLO */
	uint32_t width, height, channels; /* of PICTURE */
	stilb_image_format format;        /* of PICTURE */
	char text[SCENE_MESSAGE_TEXT];    /* ends in 0 */
} scene_message;

/* Two processes whose texts differ do not understand one another. */
void scene_stream_version(char text[static 64]);

/* passed: a descriptor that goes with it, and stays the caller's; -1: none. false: the other side is gone. */
bool scene_stream_write_message(int file, const scene_message *message, int passed);

/* *passed: a descriptor that came with it, now the caller's, or -1. */
bool scene_stream_read_message(scene_stream *stream, scene_message *message, int *passed);

/* The picture of a PICTURE message; closes file. STILB_ERROR_FILE with a reason that starts without a name. */
stilb_result scene_stream_take_picture(scene_stream *stream, const scene_message *message, int file,
                                       stilb_image *picture);

/* Models, parts, meshes, materials, the number of textures, lights, sun, sky and camera. Textures go as PICTURE
 * messages. false: the other side is gone. */
bool scene_stream_write(int file, const stilb_scene *scene);

/* textures: [count], in order; they go over to the scene, or are finished, and are {0} then. STILB_ERROR_FILE with a
 * reason that starts without a name: the stream ended or is too long, or what it says makes no scene. */
stilb_result scene_stream_read(scene_stream *stream, stilb_image *textures, uint32_t count, stilb_scene **scene);

#endif
