// The engine's only C++: a thin face of OpenImageIO that C can call. Every function catches every exception.

#include "image/image_internal.h"

#include "image/image_layers.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <cstdio>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <string>
#include <vector>

namespace
{

OIIO::TypeDesc scalar_type(image_scalar scalar)
{
	switch (scalar) {
	case IMAGE_SCALAR_U8:
		return OIIO::TypeDesc::UINT8;
	case IMAGE_SCALAR_F16:
		return OIIO::TypeDesc::HALF;
	default:
		return OIIO::TypeDesc::FLOAT;
	}
}

// One line, since it becomes part of one.
void message_set(image_message *message, const std::string &text)
{
	size_t length = text.find('\n');
	std::string line = text.substr(0, length);
	if (line.empty())
		line = "unknown error";
	strncpy(message->text, line.c_str(), sizeof message->text - 1);
	message->text[sizeof message->text - 1] = '\0';
}

// The library's threads would work beside our workers unseen by the profiler, so it gets none. Debian's build prints debug
// lines on stderr unless told not to.
void library_init()
{
	static const bool done = [] {
		OIIO::attribute("threads", 1);
		OIIO::attribute("exr_threads", -1);
		OIIO::attribute("debug", 0);
		return true;
	}();
	(void)done;
}

// What every file of ours says.
void spec_sign(OIIO::ImageSpec &spec)
{
	spec.attribute("Software", "Stilb " STILB_VERSION);
	// The EXR writer puts in the time of day unless there is a DateTime; one that is no text it leaves out.
	spec.attribute("DateTime", 0);
}

OIIO::ImageSpec file_spec(const image_shape &shape, image_scalar stored)
{
	OIIO::ImageSpec spec(int(shape.width), int(shape.height), int(shape.channels), scalar_type(stored));
	if (shape.channels == 2) {
		spec.channelnames = {"Y", "A"};
		spec.alpha_channel = 1;
	}
	spec_sign(spec);
	spec.attribute("oiio:ColorSpace", stored == IMAGE_SCALAR_U8 ? "sRGB" : "Linear");
	spec.attribute("oiio:UnassociatedAlpha", 1); // colours are stored as given, not divided by alpha
	spec.attribute("png:compressionLevel", 3);
	return spec;
}

image_outcome encode(const char *codec, const image_shape &shape, const void *pixels, image_scalar stored,
                     std::vector<unsigned char> &file, image_message *message)
{
	library_init();
	OIIO::Filesystem::IOVecOutput memory(file); // outlives output, which may write when it is destroyed
	auto output = OIIO::ImageOutput::create(codec);
	if (!output) {
		message_set(message, OIIO::geterror());
		return IMAGE_OUTCOME_CODEC;
	}
	bool done = output->set_ioproxy(&memory) && output->open(codec, file_spec(shape, stored)) &&
	            output->write_image(scalar_type(shape.scalar), pixels) && output->close();
	if (!done) {
		message_set(message, output->geterror());
		return IMAGE_OUTCOME_CODEC;
	}
	return IMAGE_OUTCOME_DONE;
}

bool is_flat(const OIIO::ImageSpec &spec, image_message *message)
{
	if (!spec.deep && spec.depth <= 1 && spec.width >= 1 && spec.height >= 1)
		return true;
	message_set(message, "not a flat picture");
	return false;
}

// How many of the file's channels are the picture: all, or R G B and perhaps A of a file with more layers, where they come
// first.
int picture_channels(const OIIO::ImageSpec &spec)
{
	const auto &names = spec.channelnames;
	if (spec.nchannels <= 4 || names[0] != "R" || names[1] != "G" || names[2] != "B")
		return spec.nchannels;
	return names[3] == "A" ? 4 : 3;
}

// False with a message for what a stilb_image cannot hold.
bool shape_of(const OIIO::ImageSpec &spec, image_scalar wanted, image_shape &shape, image_message *message)
{
	if (!is_flat(spec, message))
		return false;
	int channels = picture_channels(spec);
	if (channels < 1 || channels > 4) {
		message_set(message, "it has " + std::to_string(spec.nchannels) + " channels, and 1 to 4 are supported");
		return false;
	}
	shape = {uint32_t(spec.width), uint32_t(spec.height), uint32_t(channels), wanted};
	return true;
}

// A file in memory. OpenImageIO's own reader (2.4.7) reads before the start of its buffer when a damaged file sends it there.
class bounded_reader final : public OIIO::Filesystem::IOProxy
{
  public:
	bounded_reader(const void *data, size_t size)
		: IOProxy("", Read), data_(static_cast<const unsigned char *>(data)), size_(size)
	{
	}
	const char *proxytype() const override
	{
		return "memory";
	}
	bool seek(int64_t offset) override
	{
		if (offset < 0)
			return false;
		m_pos = offset;
		return true;
	}
	size_t read(void *out, size_t size) override
	{
		size_t got = pread(out, size, m_pos);
		m_pos += int64_t(got);
		return got;
	}
	size_t pread(void *out, size_t size, int64_t offset) override
	{
		if (offset < 0 || size_t(offset) >= size_)
			return 0;
		size_t left = size_ - size_t(offset);
		size_t got = size < left ? size : left;
		memcpy(out, data_ + offset, got);
		return got;
	}
	size_t size() const override
	{
		return size_;
	}

  private:
	const unsigned char *data_;
	size_t size_;
};

// The same for the reader of JPEG (2.4.7), which takes nothing but a FILE.
class stream_reader final : public OIIO::Filesystem::IOFile
{
  public:
	stream_reader(FILE *stream, const void *data, size_t size) : IOFile(stream, Read), memory_(data, size)
	{
	}
	size_t pread(void *out, size_t size, int64_t offset) override
	{
		return memory_.pread(out, size, offset); // its own asks for the file's number
	}
	size_t size() const override
	{
		return memory_.size();
	}

  private:
	bounded_reader memory_;
};

struct stream_closer {
	void operator()(FILE *stream) const
	{
		fclose(stream);
	}
};

image_outcome decode(const char *codec, const void *data, size_t size, image_scalar wanted, image_allocate *allocate,
                     void *context, image_message *message)
{
	library_init();
	bounded_reader memory(data, size); // all three outlive input
	std::unique_ptr<FILE, stream_closer> stream;
	std::unique_ptr<stream_reader> file;
	OIIO::Filesystem::IOProxy *proxy = &memory;
	if (strcmp(codec, "jpeg") == 0) {
		stream.reset(fmemopen(const_cast<void *>(data), size, "rb"));
		if (!stream)
			return IMAGE_OUTCOME_MEMORY;
		file = std::make_unique<stream_reader>(stream.get(), data, size);
		proxy = file.get();
	}
	// By name: OpenImageIO's own open would try every reader it has on a damaged file.
	auto input = OIIO::ImageInput::create(codec);
	if (!input) {
		message_set(message, OIIO::geterror());
		return IMAGE_OUTCOME_CODEC;
	}
	OIIO::ImageSpec spec, config;
	config.attribute("oiio:UnassociatedAlpha", 1);
	image_shape shape;
	if (!input->set_ioproxy(proxy) || !input->open(codec, spec, config)) {
		message_set(message, input->geterror());
		return IMAGE_OUTCOME_CODEC;
	}
	if (!shape_of(spec, wanted, shape, message))
		return IMAGE_OUTCOME_CODEC;
	void *pixels = allocate(context, &shape);
	if (!pixels)
		return IMAGE_OUTCOME_CALLBACK;
	if (!input->read_image(0, 0, 0, int(shape.channels), scalar_type(wanted), pixels)) {
		message_set(message, input->geterror());
		return IMAGE_OUTCOME_CODEC;
	}
	return IMAGE_OUTCOME_DONE;
}

// ---- many channels ------------------------------------------------------------------------------------------------

OIIO::ImageSpec layers_spec(const stilb_image_layers &layers)
{
	OIIO::ImageSpec spec(int(layers.width), int(layers.height), int(layers.channel_count), OIIO::TypeDesc::FLOAT);
	spec.channelnames.clear();
	spec.alpha_channel = spec.z_channel = -1;
	for (uint32_t i = 0; i < layers.channel_count; i++)
		spec.channelnames.push_back(layers.channels[i].name);
	for (uint32_t i = 0; i < layers.attribute_count; i++)
		spec.attribute(layers.attributes[i].name, layers.attributes[i].text);
	spec_sign(spec);
	spec.attribute("oiio:ColorSpace", "Linear");
	spec.attribute("compression", "zip");
	return spec;
}

// The channels of one row, side by side.
void layers_row(const stilb_image_layers &layers, uint32_t y, std::vector<float> &row)
{
	for (uint32_t i = 0; i < layers.channel_count; i++) {
		const stilb_image_channel &channel = layers.channels[i];
		const float *from = channel.values + size_t(y) * layers.width * channel.stride;
		for (uint32_t x = 0; x < layers.width; x++, from += channel.stride)
			row[size_t(x) * layers.channel_count + i] = *from;
	}
}

image_outcome encode_layers(const stilb_image_layers &layers, std::vector<unsigned char> &file, image_message *message)
{
	library_init();
	OIIO::Filesystem::IOVecOutput memory(file); // outlives output, which may write when it is destroyed
	auto output = OIIO::ImageOutput::create(IMAGE_CODEC_EXR);
	if (!output) {
		message_set(message, OIIO::geterror());
		return IMAGE_OUTCOME_CODEC;
	}
	std::vector<float> row(size_t(layers.width) * layers.channel_count);
	bool done = output->set_ioproxy(&memory) && output->open(IMAGE_CODEC_EXR, layers_spec(layers));
	for (uint32_t y = 0; done && y < layers.height; y++) {
		layers_row(layers, y, row);
		done = output->write_scanline(int(y), 0, OIIO::TypeDesc::FLOAT, row.data());
	}
	if (done && output->close())
		return IMAGE_OUTCOME_DONE;
	message_set(message, output->geterror());
	return IMAGE_OUTCOME_CODEC;
}

image_outcome decode_layers(const void *data, size_t size, const image_layers_sink &sink, image_message *message)
{
	library_init();
	bounded_reader memory(data, size); // outlives input
	auto input = OIIO::ImageInput::create(IMAGE_CODEC_EXR);
	if (!input) {
		message_set(message, OIIO::geterror());
		return IMAGE_OUTCOME_CODEC;
	}
	OIIO::ImageSpec spec;
	if (!input->set_ioproxy(&memory) || !input->open(IMAGE_CODEC_EXR, spec)) {
		message_set(message, input->geterror());
		return IMAGE_OUTCOME_CODEC;
	}
	if (!is_flat(spec, message))
		return IMAGE_OUTCOME_CODEC;
	float *pixels = sink.create(sink.context, uint32_t(spec.width), uint32_t(spec.height), uint32_t(spec.nchannels));
	bool taken = pixels != nullptr;
	for (int i = 0; taken && i < spec.nchannels; i++)
		taken = sink.channel(sink.context, spec.channelnames[size_t(i)].c_str());
	for (const auto &attribute : spec.extra_attribs) {
		if (taken && attribute.type() == OIIO::TypeDesc::STRING)
			taken = sink.attribute(sink.context, attribute.name().c_str(), attribute.get_string().c_str());
	}
	if (!taken)
		return IMAGE_OUTCOME_CALLBACK;
	if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, pixels)) {
		message_set(message, input->geterror());
		return IMAGE_OUTCOME_CODEC;
	}
	return IMAGE_OUTCOME_DONE;
}

// ---- the face ---------------------------------------------------------------------------------------------------------

// Runs body and turns what it throws into an outcome.
template <typename Body> image_outcome guarded(image_message *message, Body body)
{
	try {
		return body();
	} catch (const std::bad_alloc &) {
		return IMAGE_OUTCOME_MEMORY;
	} catch (const std::exception &error) {
		message_set(message, error.what());
	} catch (...) {
		message_set(message, "unknown error");
	}
	return IMAGE_OUTCOME_CODEC;
}

image_outcome codec_encode(const char *codec, const image_shape *shape, const void *pixels, image_scalar stored,
                           image_sink *sink, void *context, image_message *message)
{
	return guarded(message, [=] {
		std::vector<unsigned char> file;
		image_outcome outcome = encode(codec, *shape, pixels, stored, file, message);
		if (outcome != IMAGE_OUTCOME_DONE)
			return outcome;
		return sink(context, file.data(), file.size()) == 0 ? IMAGE_OUTCOME_DONE : IMAGE_OUTCOME_CALLBACK;
	});
}

image_outcome codec_decode(const char *codec, const void *data, size_t size, image_scalar wanted,
                           image_allocate *allocate, void *context, image_message *message)
{
	return guarded(message, [=] { return decode(codec, data, size, wanted, allocate, context, message); });
}

image_outcome codec_encode_layers(const stilb_image_layers *layers, image_sink *sink, void *context,
                                  image_message *message)
{
	return guarded(message, [=] {
		std::vector<unsigned char> file;
		image_outcome outcome = encode_layers(*layers, file, message);
		if (outcome != IMAGE_OUTCOME_DONE)
			return outcome;
		return sink(context, file.data(), file.size()) == 0 ? IMAGE_OUTCOME_DONE : IMAGE_OUTCOME_CALLBACK;
	});
}

image_outcome codec_decode_layers(const void *data, size_t size, const image_layers_sink *sink, image_message *message)
{
	return guarded(message, [=] { return decode_layers(data, size, *sink, message); });
}

const char *codec_version()
{
	static const std::string version = [] {
		int packed = OIIO::openimageio_version(); // 20407 for 2.4.7
		return std::to_string(packed / 10000) + "." + std::to_string(packed / 100 % 100) + "." +
		       std::to_string(packed % 100);
	}();
	return version.c_str();
}

} // namespace

extern "C" __attribute__((visibility("default"))) const image_codec image_codec_oiio; // IMAGE_CODEC_SYMBOL
const image_codec image_codec_oiio = {codec_encode, codec_decode, codec_encode_layers, codec_decode_layers,
                                      codec_version};
