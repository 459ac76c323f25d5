#include "scene/open/scene_stream_bytes.h"

#include <errno.h>
#include <poll.h>
#include <unistd.h>

bool scene_stream_put(int file, const void *data, size_t size)
{
	const char *bytes = data;
	while (size > 0) {
		ssize_t put = write(file, bytes, size);
		if (put < 0 && errno == EINTR)
			continue;
		if (put <= 0)
			return false;
		bytes += put;
		size -= (size_t)put;
	}
	return true;
}

#define STREAM_ASK_MS 50u /* between two questions whether to give up */

bool scene_stream_wait(scene_stream *stream)
{
	for (;;) {
		uint64_t now = stilb_time_ns();
		struct pollfd wait = {.fd = stream->file, .events = POLLIN};
		if (now >= stream->deadline_ns) {
			stream->late = true;
			return false;
		}
		if (stream->give_up && stream->give_up(stream->user)) {
			stream->given_up = true;
			return false;
		}
		uint64_t left_ms = (stream->deadline_ns - now) / 1000000 + 1, most_ms = stream->give_up ? STREAM_ASK_MS : 60000;
		int ready = poll(&wait, 1, (int)(left_ms < most_ms ? left_ms : most_ms));
		if (ready > 0)
			return true;
		if (ready < 0 && errno != EINTR)
			return false;
	}
}

bool scene_stream_has_room(scene_stream *stream, uint64_t size)
{
	STILB_ASSERT(stream->limit == 0 || stream->taken <= stream->limit);
	stream->too_much |= stream->limit > 0 && size > stream->limit - stream->taken;
	return !stream->too_much;
}

bool scene_stream_count(scene_stream *stream, uint64_t size)
{
	bool room = scene_stream_has_room(stream, size);
	if (room)
		stream->taken += size;
	return room;
}

bool scene_stream_get(scene_stream *stream, void *data, size_t size)
{
	STILB_ASSERT(data || size == 0);
	char *bytes = data;
	if (!scene_stream_count(stream, size))
		return false;
	while (size > 0) {
		if (!scene_stream_wait(stream))
			return false;
		ssize_t got = read(stream->file, bytes, size);
		if (got < 0 && errno == EINTR)
			continue;
		stream->ended |= got == 0;
		if (got <= 0)
			return false;
		bytes += got;
		size -= (size_t)got;
	}
	return true;
}

stilb_result scene_stream_broken(const scene_stream *stream)
{
	return stilb_fail(STILB_ERROR_FILE,
	                  stream->too_much ? "the scene is larger than an import may be" : "the scene broke off");
}

stilb_result scene_stream_wrong(const char *what)
{
	return stilb_fail(STILB_ERROR_FILE, "the scene has impossible %s", what);
}
