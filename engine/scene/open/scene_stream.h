/*
 * scene_stream: requests, answers, descriptors and scenes between Stilb and its import process, which are of the same
 * build. The process is not trusted: everything read is checked, so that a scene that has been read can be used,
 * whatever the other side sent.
 *
 * Order.       Stilb sends a request (READ_SCENE, READ_PICTURE or READ_LIGHT with the file's descriptor, or ABOUT) and
 *              listens until a result: SCENE, PICTURE, VERSION or ERROR. Meanwhile the import process may send
 *              warnings, progress and textures, and ask for further files (OPEN), each answered at once (FILE).
 * Threads.     [one-writer] per stream.
 */
#ifndef STILB_SCENE_STREAM_H
#define STILB_SCENE_STREAM_H

#include "scene/scene.h"

typedef struct scene_stream {
	int file;                    /* a socket; scenes without messages can be read from any file */
	uint64_t deadline_ns;        /* of reading, on the clock of stilb_time_ns; UINT64_MAX: none */
	uint64_t limit;              /* of bytes read, pictures behind descriptors included; 0: none */
	uint64_t taken;              /* bytes read so far, <= limit if there is one */
	bool (*give_up)(void *user); /* asked while waiting, every 50 ms at least: true ends it; NULL: never */
	void *user;
	bool late, ended, too_much; /* why reading failed: the deadline passed; the other side closed; the limit; */
	bool given_up;              /* give_up said so */
} scene_stream;

typedef enum scene_message_kind {
	/* from the import process */
	SCENE_MESSAGE_HELLO,    /* first, once; text: of scene_stream_version; flags: of scene_protection */
	SCENE_MESSAGE_WARNING,  /* at any time; text: for the user */
	SCENE_MESSAGE_PROGRESS, /* at any time; done */
	SCENE_MESSAGE_OPEN,     /* asks for a file; text: its name in the scene */
	/* Size and format, with the descriptor of the pixels: a scene's next texture, or the result of READ_PICTURE. */
	SCENE_MESSAGE_PICTURE,
	SCENE_MESSAGE_ERROR,   /* the result of any request that failed; text: the reason; result: its kind */
	SCENE_MESSAGE_SCENE,   /* the result of READ_SCENE; the scene itself follows (scene_stream_write) */
	SCENE_MESSAGE_VERSION, /* the result of ABOUT; text: lines of a library and its version */
	/* to the import process */
	SCENE_MESSAGE_FILE,         /* the answer to OPEN: a descriptor, or text: why there is none */
	SCENE_MESSAGE_READ_SCENE,   /* asks for the scene in a file, whose descriptor comes with it; text: its path */
	SCENE_MESSAGE_READ_PICTURE, /* asks for the picture in a file, whose descriptor comes with it; text: its path */
	SCENE_MESSAGE_READ_LIGHT,   /* as READ_PICTURE, converted to three channels of linear floats, finite and >= 0 */
	SCENE_MESSAGE_ABOUT,        /* asks for the names and versions of the libraries that decode files */
} scene_message_kind;

/* The protections of the import process, as flags. A kernel may lack some of them. */
typedef enum scene_protection {
	SCENE_PROTECTION_PRIVILEGES = 1, /* no_new_privs: no program gives it more rights */
	SCENE_PROTECTION_LANDLOCK = 2,   /* it can open no file but the system's libraries */
	SCENE_PROTECTION_SECCOMP = 4,    /* it can use only those system calls that decoding needs */
	SCENE_PROTECTION_LIMITS = 8,     /* of memory, file size, descriptors and time */
} scene_protection;

#define SCENE_MESSAGE_TEXT 4096 /* bytes; as long as a path may be */

typedef struct scene_message {
	scene_message_kind kind;
	stilb_result result;              /* of ERROR */
	float done;                       /* of PROGRESS: the share of the file that is converted */
	uint32_t flags;                   /* of HELLO; of OPEN 1: the process warns itself if the file is refused */
	uint32_t width, height, channels; /* of PICTURE */
	stilb_image_format format;        /* of PICTURE */
	uint32_t levels;                  /* of PICTURE: mip levels */
	char text[SCENE_MESSAGE_TEXT];    /* ends with 0 */
} scene_message;

/* A text that is the same for all programs of a build: with another one no messages can be exchanged. */
void scene_stream_version(char text[static 64]);

/* Sends a message to the socket file, with a copy of the descriptor passed; -1: none. False: the other side is gone. */
bool scene_stream_write_message(int file, const scene_message *message, int passed);

/* Reads a message, and its descriptor into *passed, to be closed by the caller; -1: it brought none. Its text ends with
 * 0; everything else in it is unchecked. False: one of the stream's flags late, ended and too_much says why. */
bool scene_stream_read_message(scene_stream *stream, scene_message *message, int *passed);

/* Receives the picture of a PICTURE message (stilb_image_receive); closes file, its descriptor or -1. STILB_ERROR_FILE,
 * STILB_ERROR_MEMORY; the message is a reason without the file's name, and picture is {0} then. */
stilb_result scene_stream_take_picture(scene_stream *stream, const scene_message *message, int file,
                                       stilb_image *picture);

/* Writes models, parts, meshes, materials, the number of textures, lights, the colours of sky and ground, and
 * cameras: the reader of a scene without any frames it. Textures are sent before, as PICTURE messages. False: the other
 * side is gone. */
bool scene_stream_write(int file, const stilb_scene *scene);

/* Reads a scene and moves textures, [count], into it; they are {0} afterwards, also after a failure. STILB_ERROR_FILE:
 * the stream broke off, is too long, or has indices or numbers that no scene has; STILB_ERROR_MEMORY. The message is a
 * reason without the file's name, and *scene is NULL then. */
stilb_result scene_stream_read(scene_stream *stream, stilb_image *textures, uint32_t count, stilb_scene **scene);

#endif
