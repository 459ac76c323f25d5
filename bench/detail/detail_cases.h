/*
 * detail_cases: the cases of the suites `lod` and `pop`, levels of detail: X(NAME, TITLE, METRICS, MODELS, WIDTH,
 * HEIGHT) with METRICS a list of bench_metric in bench_detail.c; of clusters MODELS are triangles. But for `horde` and
 * `clusters` they draw the stress test with the modes of `--lod` in turn, in one process.
 */
#ifndef DETAIL_CASES_H
#define DETAIL_CASES_H

/* Frames of a still camera that sees all models. */
#define DETAIL_FRAMES(X)                                                                                               \
	X("frame-360", "10,000 models in 640x360: CPU time of a frame", frame, 10000, 640, 360)                            \
	X("frame-720", "10,000 models in 1280x720: CPU time of a frame", frame, 10000, 1280, 720)                          \
	X("many-360", "100,000 models in 640x360: CPU time of a frame", frame, 100000, 640, 360)                           \
	X("many-720", "100,000 models in 1280x720: CPU time of a frame", frame, 100000, 1280, 720)

/* Recording alone, on the null device; a camera that flies away, so that levels change; a million models. */
#define DETAIL_OTHERS(X)                                                                                               \
	X("record", "10,000 models: CPU time of recording a frame", record, 10000, 1280, 720)                              \
	X("flight", "10,000 models in 1280x720: CPU time of a frame while the camera moves by 1 % a frame", flight, 10000, \
	  1280, 720)                                                                                                       \
	X("million", "1,000,000 models in 1280x720: CPU time of a frame, and memory", million, 1000000, 1280, 720)         \
	X("horde", "100,000 people in 1280x720: CPU time of a frame as impostors and as meshes, and their difference",     \
	  horde, 100000, 1280, 720)                                                                                        \
	X("clusters",                                                                                                      \
	  "a mesh of 10,000,000 triangles in 1280x720, seen from its surface and as a whole: CPU time of a frame, "        \
	  "triangles for each of its pixels",                                                                              \
	  clusters, 10000000, 1280, 720)                                                                                   \
	X("vertices", "a mesh of 1,000,000 triangles in 640x360: CPU time with packed vertices and with floats", vertices, \
	  1000, 640, 360)                                                                                                  \
	X("vertices-small", "the same with 100,000 triangles", vertices, 100, 640, 360)                                    \
	X("memory-10000", "10,000 models: MiB of scene and renderer", memory, 10000, 640, 360)                             \
	X("memory-million", "1,000,000 models: MiB of scene and renderer", memory, 1000000, 640, 360)                      \
	X("memory-mesh", "a mesh of 1,000,000 triangles: MiB of scene and renderer", memory, 0, 640, 360)

/* A still camera, and an allowed error that grows from 0.36 to 0.68 pixels by 1 % a frame, as if the camera went away
 * by 1 % a frame but the picture stayed: all that changes is what levels of detail change. Pictures have four samples a
 * pixel. 0 models: six boulders with long chains of levels, 100 pixels wide. static: of pixels in which no frame shows
 * more or less of any model than another. nearer: the largest of the factors 1, 2^(1/2), 2, ..., 16 by which all errors
 * may be larger until the worst change is more than popping's without a factor: of 8 x 8 static pixels, of 8 x 8 pixels
 * anywhere, of a static pixel. */
#define DETAIL_POPS(X)                                                                                                 \
	X("changes", "worst change between frames, and difference from full detail at 0.5 pixels, % of white", pop, 400,   \
	  320, 180)                                                                                                        \
	X("boulders", "the same of six large ones", pop, 0, 320, 180)                                                      \
	X("nearer", "how much larger errors may be at the worst change of popping, of large ones", nearer, 0, 320, 180)

#endif
