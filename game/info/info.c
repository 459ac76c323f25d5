/* stilb info: lists the CPU's features, the GPUs, the libraries, and the guards (like seccomp) of the process in which
 * foreign scenes and pictures are read. */
#include "game/cli/flags.h"
#include "game/commands.h"

#include "info_materials.h"
#include "info_scene.h"

#include "base/base_file.h"
#include "base/base_json.h"
#include "engine.h"
#include "gi/gi_scene.h"

#include <stdio.h>

#define INFO_MAX_GPUS 32u
#define INFO_LIBRARIES (STILB_ENGINE_LIBRARIES + 3)

typedef struct info_machine {
	stilb_cpu_features cpu;
	uint32_t cpus; /* usable by this process */
	stilb_gpu_listed gpus[INFO_MAX_GPUS];
	uint32_t gpu_count;
	const char *gpu_error; /* the reason why no GPU could be listed; NULL: they are listed */
	stilb_engine_library libraries[INFO_LIBRARIES];
	uint32_t library_count;
	stilb_scene_import_info import;
} info_machine;

typedef struct info_feature {
	const char *name;
	bool there;
} info_feature;

#define INFO_FEATURES 6

static void info_cpu_features(const stilb_cpu_features *cpu, info_feature features[INFO_FEATURES])
{
	features[0] = (info_feature){"sse4.2", cpu->sse42};
	features[1] = (info_feature){"avx2", cpu->avx2};
	features[2] = (info_feature){"fma", cpu->fma};
	features[3] = (info_feature){"f16c", cpu->f16c};
	features[4] = (info_feature){"avx512", cpu->avx512};
	features[5] = (info_feature){"invariant_tsc", cpu->invariant_tsc};
}

#define INFO_GUARDS 4

static void info_import_guards(const stilb_scene_import_info *import, info_feature guards[INFO_GUARDS])
{
	guards[0] = (info_feature){"landlock", import->landlock};
	guards[1] = (info_feature){"seccomp", import->seccomp};
	guards[2] = (info_feature){"no_new_privs", import->privileges};
	guards[3] = (info_feature){"limits", import->limits};
}

static void info_query(info_machine *machine)
{
	machine->cpu = stilb_cpu_query();
	machine->cpus = stilb_job_cpu_count();
	if (stilb_gpu_list(machine->gpus, INFO_MAX_GPUS, &machine->gpu_count) != STILB_OK)
		machine->gpu_error = stilb_error_message();
	machine->library_count = stilb_engine_libraries(machine->libraries);
	machine->libraries[machine->library_count++] = (stilb_engine_library){"Embree", stilb_gi_library_version()};
	machine->import = stilb_scene_import_query();
	machine->libraries[machine->library_count++] = (stilb_engine_library){"Assimp", machine->import.assimp};
	machine->libraries[machine->library_count++] = (stilb_engine_library){"OpenImageIO", machine->import.openimageio};
}

/* What the device reads as it is; all else is decoded before (docs/rendering.md). */
static const char *info_compressed(const stilb_gpu_listed *gpu)
{
	if (!gpu->bc)
		return "none; they are decoded";
	return strcmp(gpu->type, "software") == 0
	           ? "BC1, BC3, BC4, BC5; BC7 is decoded, which software reads 40 times slower"
	           : "BC1, BC3, BC4, BC5, BC7";
}

static void info_print(FILE *out, const info_machine *machine)
{
	info_feature features[INFO_FEATURES];
	info_cpu_features(&machine->cpu, features);
	fprintf(out, "Stilb " STILB_VERSION "\n\nCPU: %s, %u usable\n    ", machine->cpu.name, machine->cpus);
	for (int i = 0; i < INFO_FEATURES; i++)
		fprintf(out, " %s%s", features[i].there ? "" : "no-", features[i].name);
	fprintf(out, "\n\nGPUs (--gpu takes the number or a part of the name):\n");
	for (uint32_t i = 0; i < machine->gpu_count; i++) {
		const stilb_gpu_listed *gpu = &machine->gpus[i];
		fprintf(out, "  %u  %s, %s, Vulkan %s\n     %s\n", i, gpu->name, gpu->type, gpu->api_version, gpu->driver);
		if (gpu->missing)
			fprintf(out, "     cannot run Stilb: it lacks %s\n", gpu->missing);
		fprintf(out, "     compressed textures: %s\n", info_compressed(gpu));
	}
	if (machine->gpu_error)
		fprintf(out, "  none: %s\n", machine->gpu_error);
	fprintf(out, "\nLibraries:\n");
	for (uint32_t i = 0; i < machine->library_count; i++)
		fprintf(out, "  %-14s %s\n", machine->libraries[i].name, machine->libraries[i].version);
	info_feature guards[INFO_GUARDS];
	info_import_guards(&machine->import, guards);
	fprintf(out, "\nForeign scenes and pictures are read in a process of their own, guarded by:\n ");
	for (int i = 0; i < INFO_GUARDS; i++)
		fprintf(out, " %s%s", guards[i].there ? "" : "no-", guards[i].name);
	fprintf(out, "\n");
}

static void info_json_gpus(stilb_json *json, const info_machine *machine)
{
	stilb_json_begin(json, "gpus", '[');
	for (uint32_t i = 0; i < machine->gpu_count; i++) {
		const stilb_gpu_listed *gpu = &machine->gpus[i];
		stilb_json_begin(json, NULL, '{');
		stilb_json_string(json, "name", gpu->name);
		stilb_json_string(json, "type", gpu->type);
		stilb_json_string(json, "driver", gpu->driver);
		stilb_json_string(json, "vulkan", gpu->api_version);
		stilb_json_string(json, "missing", gpu->missing ? gpu->missing : "");
		stilb_json_string(json, "compressed", info_compressed(gpu));
		stilb_json_end(json, '}');
	}
	stilb_json_end(json, ']');
}

static stilb_result info_save(const info_machine *machine, const char *path)
{
	info_feature features[INFO_FEATURES];
	info_cpu_features(&machine->cpu, features);
	stilb_json json = {0};
	stilb_json_begin(&json, NULL, '{');
	stilb_json_string(&json, "version", STILB_VERSION);
	stilb_json_begin(&json, "cpu", '{');
	stilb_json_string(&json, "name", machine->cpu.name);
	stilb_json_int(&json, "usable", machine->cpus);
	stilb_json_begin(&json, "features", '{');
	for (int i = 0; i < INFO_FEATURES; i++)
		stilb_json_bool(&json, features[i].name, features[i].there);
	stilb_json_end(&json, '}');
	stilb_json_end(&json, '}');
	info_json_gpus(&json, machine);
	info_feature guards[INFO_GUARDS];
	info_import_guards(&machine->import, guards);
	stilb_json_begin(&json, "import", '{');
	for (int i = 0; i < INFO_GUARDS; i++)
		stilb_json_bool(&json, guards[i].name, guards[i].there);
	stilb_json_end(&json, '}');
	stilb_json_begin(&json, "libraries", '{');
	for (uint32_t i = 0; i < machine->library_count; i++)
		stilb_json_string(&json, machine->libraries[i].name, machine->libraries[i].version);
	stilb_json_end(&json, '}');
	stilb_json_end(&json, '}');
	return stilb_json_save(&json, path);
}

int info_command(int argc, char **argv)
{
	const char *path = NULL, *scene = NULL;
	bool allow_outside = false, quiet = false, materials = false;
	const flag flags[] = {
		{"scene", FLAG_WORD, &scene, NULL, NULL, 0, 0, NULL},
		{"--json", FLAG_TEXT, &path, "FILE", "write the list as JSON too; - is standard output", 0, 0, NULL},
		{"--allow-outside", FLAG_SWITCH, &allow_outside, NULL,
	     "let the scene's file name files outside its folder and the parent of that", 0, 0, NULL},
		{"--materials", FLAG_SWITCH, &materials, NULL, "print what pictures show of the materials of files, and end", 0,
	     0, NULL},
		{"--quiet", FLAG_SWITCH, &quiet, NULL, "do not list what the scene's file has that is not shown", 0, 0, NULL},
	};
	size_t flag_count = sizeof flags / sizeof *flags;
	flags_result parsed = flags_parse(flags, flag_count, argc, argv);
	if (parsed == FLAGS_HELP) {
		printf(
			"stilb info [SCENE] [FLAGS]: lists what this machine offers: CPU features, GPUs, libraries. With SCENE, a\n"
			"file (glTF, OBJ, ...) or a built-in scene, what is in that: triangles, materials, textures, lights.\n\n");
		flags_print(flags, flag_count);
		return EXIT_DONE;
	}
	if (parsed == FLAGS_REFUSED)
		return EXIT_REFUSED;
	if (path && stilb_file_check(path) != STILB_OK) {
		stilb_log("%s", stilb_error_message());
		return EXIT_REFUSED;
	}
	if (materials) {
		info_print_materials(stdout);
		return EXIT_DONE;
	}
	if (scene)
		return info_scene(scene, allow_outside, quiet, path);
	static info_machine machine;
	info_query(&machine);
	info_print(path && stilb_file_is_stdout(path) ? stderr : stdout, &machine);
	if (path && info_save(&machine, path) != STILB_OK) {
		stilb_log("%s", stilb_error_message());
		return EXIT_FAILED;
	}
	return EXIT_DONE;
}
