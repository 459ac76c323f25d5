// EXR through OpenEXR's C++ library, behind functions that C can call; no exception leaves them. OpenEXR's C library
// (OpenEXRCore 3.1.5) is not used: it gives wrong pixels for some files (RGBA of halves, DWA of floats) and reads past
// its buffers in damaged ones.
#include "image/image_exr.h"

#include "image/image_layers.h"

#include <Imath/ImathBox.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <Imath/half.h>
#include <algorithm>
#include <cstring>
#include <exception>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

namespace
{

// Runs body, and converts an exception to an outcome with a message.
template <typename Body> image_outcome guarded(image_message *message, Body body)
{
	try {
		return body();
	} catch (const std::bad_alloc &) {
		return IMAGE_OUTCOME_MEMORY;
	} catch (const std::exception &error) {
		image_message_set(message, error.what());
	} catch (...) {
		image_message_set(message, "unknown error");
	}
	return IMAGE_OUTCOME_CODEC;
}

// ---- files in memory ------------------------------------------------------------------------------------------------

class memory_output final : public Imf::OStream
{
  public:
	explicit memory_output(image_bytes *bytes) : OStream("memory"), bytes_(bytes)
	{
	}
	void write(const char data[], int size) override
	{
		if (!image_bytes_write(bytes_, size_t(at_), data, size_t(size)))
			throw std::bad_alloc();
		at_ += uint64_t(size);
	}
	uint64_t tellp() override
	{
		return at_;
	}
	void seekp(uint64_t position) override
	{
		at_ = position; // the library goes back to write its table of rows, then to the end
	}

  private:
	image_bytes *bytes_;
	uint64_t at_ = 0;
};

class memory_input final : public Imf::IStream
{
  public:
	memory_input(const void *data, size_t size) : IStream("memory"), data_(static_cast<const char *>(data)), size_(size)
	{
	}
	bool read(char out[], int size) override
	{
		if (size < 0 || at_ > size_ || uint64_t(size) > size_ - at_)
			throw std::runtime_error("the file is cut off or damaged");
		memcpy(out, data_ + at_, size_t(size));
		at_ += uint64_t(size);
		return at_ < size_;
	}
	uint64_t tellg() override
	{
		return at_;
	}
	void seekg(uint64_t position) override
	{
		at_ = position;
	}

  private:
	const char *data_;
	uint64_t size_, at_ = 0;
};

// ---- writing --------------------------------------------------------------------------------------------------------

// OpenEXR takes mutable pointers; the slices of an output are only read.
char *slice_base(const void *first)
{
	return static_cast<char *>(const_cast<void *>(first));
}

image_outcome encode(const image_exr_file &from, image_bytes *file)
{
	const bool halves = from.stored == IMAGE_SCALAR_F16;
	const Imf::PixelType type = halves ? Imf::HALF : Imf::FLOAT;
	Imf::Header header(int(from.width), int(from.height));
	header.compression() = Imf::ZIP_COMPRESSION;
	header.insert("Software", Imf::StringAttribute("Stilb " STILB_VERSION));
	for (uint32_t i = 0; i < from.attribute_count; i++)
		header.insert(from.attributes[i].name, Imf::StringAttribute(from.attributes[i].text));
	Imf::FrameBuffer frame;
	std::vector<std::vector<half>> converted; // the channels, if floats are stored as halves
	for (uint32_t i = 0; i < from.channel_count; i++) {
		const image_exr_channel &channel = from.channels[i];
		header.channels().insert(channel.name, Imf::Channel(type));
		if (halves && from.scalar == IMAGE_SCALAR_F32) {
			std::vector<half> &plane = converted.emplace_back(size_t(from.width) * from.height);
			for (uint32_t y = 0; y < from.height; y++)
				for (uint32_t x = 0; x < from.width; x++) {
					float value;
					const char *row = static_cast<const char *>(channel.first) + y * channel.row_step;
					memcpy(&value, row + x * channel.pixel_step, sizeof value);
					plane[size_t(y) * from.width + x] = half(value);
				}
			frame.insert(channel.name,
			             Imf::Slice(type, slice_base(plane.data()), sizeof(half), sizeof(half) * from.width));
		} else {
			frame.insert(channel.name,
			             Imf::Slice(type, slice_base(channel.first), channel.pixel_step, channel.row_step));
		}
	}
	memory_output stream(file); // outlives output, which writes its table of rows when it is destroyed
	Imf::OutputFile output(stream, header, 0);
	output.setFrameBuffer(frame);
	output.writePixels(int(from.height));
	return IMAGE_OUTCOME_DONE;
}

image_outcome encode_picture(const image_input *input, image_bytes *file, image_message *message)
{
	const image_shape *shape = &input->shape;
	static const char *const names[5][4] = {{}, {"Y"}, {"Y", "A"}, {"R", "G", "B"}, {"R", "G", "B", "A"}};
	const size_t scalar = image_scalar_bytes[shape->scalar], step = shape->channels * scalar;
	image_exr_channel channels[4];
	for (uint32_t c = 0; c < shape->channels; c++)
		channels[c] = {names[shape->channels][c], static_cast<const char *>(input->pixels) + c * scalar, step,
		               step * shape->width};
	const image_exr_file from = {shape->width, shape->height,     shape->channels, input->attribute_count,
	                             channels,     input->attributes, shape->scalar,   input->stored};
	return image_exr_encode(&from, file, message);
}

// ---- reading --------------------------------------------------------------------------------------------------------

// Rank of a channel within its layer, by the last part of its name: R, G, B, X, Y, Z and A first, in that order.
int channel_rank(const std::string &name)
{
	static const char ranks[] = "RGBXYZA";
	const char *found = name.size() == 1 ? strchr(ranks, name[0]) : nullptr;
	return found ? int(found - ranks) : 100;
}

// The order of channels that image_exr_decode documents.
bool channel_before(const std::string &a, const std::string &b)
{
	const size_t dot_a = a.rfind('.'), dot_b = b.rfind('.');
	const std::string layer_a = dot_a == std::string::npos ? "" : a.substr(0, dot_a);
	const std::string layer_b = dot_b == std::string::npos ? "" : b.substr(0, dot_b);
	if (layer_a != layer_b)
		return layer_a < layer_b;
	const int rank_a = channel_rank(dot_a == std::string::npos ? a : a.substr(dot_a + 1));
	const int rank_b = channel_rank(dot_b == std::string::npos ? b : b.substr(dot_b + 1));
	return rank_a != rank_b ? rank_a < rank_b : a < b;
}

// The first part of a file. The constructor reads its header; throws if it cannot be decoded.
class exr_input
{
  public:
	exr_input(const void *data, size_t size) : stream_(data, size), file_(stream_, 0, false)
	{
		const Imf::Header &first = header();
		const Imath::Box2i window = first.dataWindow();
		const int64_t across = int64_t(window.max.x) - window.min.x + 1,
					  down = int64_t(window.max.y) - window.min.y + 1;
		if ((first.hasType() && Imf::isDeepData(first.type())) || across < 1 || down < 1)
			throw std::runtime_error("not a flat picture");
		width = uint32_t(across); // corners are int32 and ordered, so this fits
		height = uint32_t(down);
		for (auto i = first.channels().begin(); i != first.channels().end(); ++i) {
			if (i.channel().xSampling != 1 || i.channel().ySampling != 1)
				throw std::runtime_error("it has channels of different resolutions");
			names.push_back(i.name());
		}
		std::sort(names.begin(), names.end(), channel_before);
	}
	const Imf::Header &header() const
	{
		return file_.header(0);
	}
	// F16 if the first `count` channels are halves.
	image_scalar scalar(uint32_t count) const
	{
		bool halves = true;
		for (uint32_t i = 0; i < count; i++)
			halves = halves && header().channels()[names[i].c_str()].type == Imf::HALF;
		return halves ? IMAGE_SCALAR_F16 : IMAGE_SCALAR_F32;
	}
	// The first `count` channels side by side, as F16 or F32.
	void read(void *pixels, uint32_t count, image_scalar scalar)
	{
		const Imath::Box2i window = header().dataWindow();
		const size_t step = count * image_scalar_bytes[scalar], row = step * width;
		// OpenEXR addresses a slice by window coordinates: its base is the address of the pixel (0, 0), which may lie
		// outside of the memory.
		const int64_t corner = int64_t(window.min.y) * int64_t(row) + int64_t(window.min.x) * int64_t(step);
		const Imf::PixelType type = scalar == IMAGE_SCALAR_F16 ? Imf::HALF : Imf::FLOAT;
		Imf::FrameBuffer frame;
		for (uint32_t i = 0; i < count; i++) {
			const uintptr_t first = reinterpret_cast<uintptr_t>(pixels) + i * image_scalar_bytes[scalar];
			frame.insert(names[i], Imf::Slice(type, reinterpret_cast<char *>(first - uintptr_t(corner)), step, row));
		}
		Imf::InputPart part(file_, 0);
		part.setFrameBuffer(frame);
		part.readPixels(window.min.y, window.max.y);
	}

  private:
	memory_input stream_; // outlives file_
	Imf::MultiPartInputFile file_;

  public:
	uint32_t width, height;
	std::vector<std::string> names; // of all channels, sorted by channel_before
};

// How many of the sorted channels, from the first on, make the picture: all if there are at most four, of more R G B
// and A if there is one; 0: there are more than four, but no R G B.
uint32_t picture_channels(const std::vector<std::string> &names)
{
	if (names.size() <= 4)
		return uint32_t(names.size());
	if (names[0] != "R" || names[1] != "G" || names[2] != "B")
		return 0;
	return names[3] == "A" ? 4 : 3;
}

image_outcome decode_picture(const void *data, size_t size, image_allocate *allocate, void *context,
                             image_message *message)
{
	return guarded(message, [=] {
		exr_input input(data, size);
		const uint32_t channels = picture_channels(input.names);
		if (channels == 0)
			throw std::runtime_error("it has " + std::to_string(input.names.size()) +
			                         " channels, and 1 to 4 are supported");
		image_shape shape = {input.width, input.height, channels, input.scalar(channels)};
		void *pixels = allocate(context, &shape);
		if (!pixels)
			return IMAGE_OUTCOME_CALLBACK;
		input.read(pixels, channels, shape.scalar);
		return IMAGE_OUTCOME_DONE;
	});
}

// Hands names and text attributes to the sink. False: the sink is out of memory.
bool tell_texts(const exr_input &input, const image_exr_sink &sink)
{
	bool taken = true;
	for (size_t i = 0; taken && i < input.names.size(); i++)
		taken = sink.channel(sink.context, input.names[i].c_str());
	for (auto i = input.header().begin(); taken && i != input.header().end(); ++i) {
		const auto *text = dynamic_cast<const Imf::StringAttribute *>(&i.attribute());
		if (text)
			taken = sink.attribute(sink.context, i.name(), text->value().c_str());
	}
	return taken;
}

} // namespace

// ---- for C ----------------------------------------------------------------------------------------------------------

image_outcome image_exr_encode(const image_exr_file *from, image_bytes *file, image_message *message)
{
	return guarded(message, [=] { return encode(*from, file); });
}

image_outcome image_exr_decode(const void *data, size_t size, const image_exr_sink *sink, image_message *message)
{
	return guarded(message, [=] {
		exr_input input(data, size);
		const auto count = uint32_t(input.names.size());
		float *pixels = sink->create(sink->context, input.width, input.height, count);
		if (!pixels || !tell_texts(input, *sink))
			return IMAGE_OUTCOME_CALLBACK;
		input.read(pixels, count, IMAGE_SCALAR_F32);
		return IMAGE_OUTCOME_DONE;
	});
}

const image_codec image_codec_exr = {".exr", false, encode_picture, decode_picture};
