/* The contracts of image, each broken on purpose. */
#include "image/image.h"
#include "image/image_compare.h"
#include "image/image_import.h"
#include "image/image_internal.h"
#include "image/image_layers.h"
#include "image/image_normals.h"
#include "support/contract.h"
#include "support/test.h"
static stilb_image made(uint32_t channels, stilb_image_format format)
{
	stilb_image image;
	assert_int_equal(stilb_image_create(&image, 3, 2, channels, format), STILB_OK);
	return image;
}

static void lend_too_much(void)
{
	stilb_image image;
	stilb_image_create_shared(&image, 1024, STILB_IMAGE_LEND_MAX / 1024 + 1, 1, STILB_IMAGE_U8_SRGB);
	stilb_image_lend(&image);
}

static void pictures(void **state)
{
	(void)state;
	stilb_image image = made(3, STILB_IMAGE_F32_LINEAR), damaged = image, empty = {0};
	float row[9];
	contract_breaks("y < image->height", stilb_image_row_to_light(&image, 2, row));
	contract_breaks("`light'", stilb_image_row_to_light(&image, 0, NULL));
	contract_breaks("image_is_sound(image)", stilb_image_row_to_light(&empty, 0, row));
	damaged.channels = 5;
	contract_breaks("image->channels <= 4", stilb_image_size(&damaged));
	damaged = image, damaged.format = STILB_IMAGE_FORMAT_COUNT;
	contract_breaks("image->format <", stilb_image_size(&damaged));
	contract_breaks("format <", stilb_image_format_as_data(STILB_IMAGE_FORMAT_COUNT));
	contract_breaks("format <", stilb_image_format_is_blocks(STILB_IMAGE_FORMAT_COUNT));
	contract_breaks("level <", stilb_image_level(&image, 1));
	contract_breaks("image && texels", stilb_image_decode(&image, NULL));
	damaged = image, damaged.pixels = NULL, damaged.storage = 1;
	contract_breaks("mapped memory has an address", stilb_image_finish(&damaged));
	contract_breaks("`image'", stilb_image_create(NULL, 1, 1, 1, STILB_IMAGE_U8_SRGB));
	contract_breaks("made by stilb_image_create_shared", stilb_image_share(&image));
	contract_breaks("made by stilb_image_create_shared", stilb_image_lend(&image));
	contract_breaks("made by stilb_image_create_shared",
	                stilb_image_reshape_shared(&image, 1, 1, 1, STILB_IMAGE_U8_SRGB));
	contract_breaks("stilb_image_levels_size(image) <= (16u << 20)", lend_too_much());
	contract_breaks("file >= 0", stilb_image_receive(-1, 1, 1, 1, STILB_IMAGE_U8_SRGB, 1, &damaged));
	stilb_image_finish(&image);
}

static void *allocate_nothing(void *context, image_shape *shape)
{
	(void)context, (void)shape;
	return NULL;
}

static void files(void **state)
{
	(void)state;
	stilb_image image = made(3, STILB_IMAGE_F32_LINEAR), empty = {0};
	image_shape shape = {3, 2, 3, IMAGE_SCALAR_F32};
	image_input input = {.shape = shape, .stored = IMAGE_SCALAR_F32, .pixels = image.pixels};
	image_bytes file = {0};
	image_message message = {0};
	void *data = NULL;
	size_t size;
	contract_breaks("`path'", stilb_image_path_check(NULL));
	contract_breaks("`path'", stilb_image_path_is_light(NULL));
	contract_breaks("image && path", stilb_image_save(NULL, "a.png"));
	contract_breaks("path && image", stilb_image_load(NULL, &image));
	contract_breaks("!*data", image_file_read("a.png", &image.pixels, &size));
	contract_breaks("path && size && data", image_file_read(NULL, &data, &size));
	contract_breaks("no gap", image_bytes_write(&file, 1, "x", 1));
	contract_breaks("message && text", image_message_set(&message, NULL));
	contract_breaks("shape.scalar ==", image_codec_png.encode(&input, &file, &message));
	contract_breaks("data && allocate", image_codec_png.decode(NULL, 0, allocate_nothing, NULL, &message));
	contract_breaks("data && allocate", image_codec_hdr.decode("", 0, NULL, NULL, &message));
	input.shape.scalar = IMAGE_SCALAR_F16;
	contract_breaks("shape->scalar ==", image_codec_hdr.encode(&input, &file, &message));
	image_load load = {.path = "a.png", .image = &image};
	contract_breaks("a codec allocates once", image_load_allocate(&load, &shape));
	load.image = &empty;
	contract_breaks("decoded into a picture", image_load_end(&load, IMAGE_OUTCOME_DONE, &message));
	contract_breaks("a refusal has a result", image_load_end(&load, IMAGE_OUTCOME_CALLBACK, &message));
	contract_breaks("outcome == IMAGE_OUTCOME_MEMORY", image_fail(IMAGE_OUTCOME_DONE, "read", "a.png", &message));
	contract_breaks("name && image", stilb_image_import_memory(NULL, "", 0, 0, &empty));
	contract_breaks("data || size == 0", stilb_image_import_memory("a", NULL, 1, 0, &empty));
	contract_breaks("flags & STILB_IMAGE_IMPORT_SHARED", stilb_image_import_memory("a", "", 0, 4, &empty));
	contract_breaks("flags <=", stilb_image_import_memory("a", "", 0, 16, &empty));
	contract_breaks("!(flags & STILB_IMAGE_IMPORT_AGAIN)", stilb_image_import("a", 5, &empty));
	stilb_image_finish(&image);
}

static void layers(void **state)
{
	(void)state;
	float value = 1.0f;
	stilb_image_channel channel = {.name = "Y", .values = &value, .stride = 1};
	stilb_image_layers one = {.width = 1, .height = 1, .channel_count = 1, .channels = &channel};
	stilb_image_layers *out;
	contract_breaks("layers && path", stilb_image_layers_save(NULL, "a.exr"));
	contract_breaks("path && layers", stilb_image_layers_load("a.exr", NULL));
	contract_breaks("path && layers", stilb_image_layers_load(NULL, &out));
	contract_breaks("layers && name", stilb_image_layers_channel(&one, NULL));
	contract_breaks("layers && name", stilb_image_layers_attribute(&one, NULL));
	one.attribute_count = 1;
	contract_breaks("layers->attributes ||", stilb_image_layers_save(&one, "a.exr"));
	one.attribute_count = 0, channel.stride = 0;
	contract_breaks("channel->stride >= 1", stilb_image_layers_save(&one, "a.exr"));
}

static void normals(void **state)
{
	(void)state;
	stilb_image image = made(3, STILB_IMAGE_F32_LINEAR);
	stilb_image_normals_desc desc = stilb_image_normals_desc_default(&image);
	stilb_image_normals chain = {.level_count = STILB_IMAGE_NORMALS_LEVELS + 1};
	contract_breaks("desc && chain", stilb_image_normals_create(NULL, &chain));
	contract_breaks("desc && chain", stilb_image_normals_create(&desc, NULL));
	contract_breaks("level_count <=", stilb_image_normals_finish(&chain));
	stilb_image_finish(&image);
}

static void comparisons(void **state)
{
	(void)state;
	stilb_image image = made(3, STILB_IMAGE_F32_LINEAR), empty = {0}, mask = {0};
	stilb_image_comparison out;
	double db;
	contract_breaks("`out'", stilb_image_compare(&image, &image, NULL, 0.0, NULL));
	contract_breaks("bound >=", stilb_image_compare(&image, &image, NULL, -1.0, &out));
	contract_breaks("image_is_sound(a)", stilb_image_compare(&empty, &image, NULL, 0.0, &out));
	contract_breaks("image_is_sound(b)", stilb_image_compare(&image, &empty, NULL, 0.0, &out));
	contract_breaks("!mask ||", stilb_image_compare(&image, &image, &empty, 0.0, &out));
	contract_breaks("`db'", stilb_image_fidelity(&image, &image, NULL, NULL));
	contract_breaks("image_is_sound(a)", stilb_image_fidelity(&empty, &image, NULL, &db));
	contract_breaks("`mask'", stilb_image_mask_edges(&image, 0.0f, 0.0f, 0, NULL));
	contract_breaks("image_is_sound(picture)", stilb_image_mask_edges(&empty, 0.0f, 0.0f, 0, &mask));
	contract_breaks("step >=", stilb_image_mask_edges(&image, -1.0f, 0.0f, 0, &mask));
	contract_breaks("distance <=", stilb_image_mask_edges(&image, 0.0f, 0.0f, UINT32_MAX, &mask));
	stilb_image_finish(&image);
}

int main(void)
{
	struct CMUnitTest tests[] = {
		cmocka_unit_test(comparisons), cmocka_unit_test(pictures), cmocka_unit_test(files),
		cmocka_unit_test(layers),      cmocka_unit_test(normals),
	};
	return cmocka_run_group_tests(tests, NULL, NULL);
}
