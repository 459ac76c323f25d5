// OpenImageIO behind functions that C can call; no exception leaves them.

#include "image/image_internal.h"

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

// Sets message to the first line of text.
void message_set(image_message *message, const std::string &text)
{
	size_t length = text.find('\n');
	std::string line = text.substr(0, length);
	if (line.empty())
		line = "unknown error";
	strncpy(message->text, line.c_str(), sizeof message->text - 1);
	message->text[sizeof message->text - 1] = '\0';
}

// One thread: the import process decodes several pictures at a time itself. Debian's build prints debug lines on stderr
// unless told not to.
void library_init()
{
	static const bool done = [] {
		OIIO::attribute("threads", 1);
		OIIO::attribute("debug", 0);
		return true;
	}();
	(void)done;
}

bool is_flat(const OIIO::ImageSpec &spec, image_message *message)
{
	if (!spec.deep && spec.depth <= 1 && spec.width >= 1 && spec.height >= 1)
		return true;
	message_set(message, "not a flat picture");
	return false;
}

// The smallest scalar that holds the file's values.
image_scalar scalar_of(OIIO::TypeDesc type)
{
	switch (type.basetype) {
	case OIIO::TypeDesc::UINT8:
	case OIIO::TypeDesc::INT8:
		return IMAGE_SCALAR_U8;
	case OIIO::TypeDesc::HALF:
		return IMAGE_SCALAR_F16;
	case OIIO::TypeDesc::FLOAT:
	case OIIO::TypeDesc::DOUBLE:
		return IMAGE_SCALAR_F32;
	default:
		return IMAGE_SCALAR_U16;
	}
}

OIIO::TypeDesc type_of(image_scalar scalar)
{
	static const OIIO::TypeDesc::BASETYPE types[] = {OIIO::TypeDesc::UINT8, OIIO::TypeDesc::HALF, OIIO::TypeDesc::FLOAT,
	                                                 OIIO::TypeDesc::UINT16};
	return types[scalar];
}

// False with a message if a stilb_image cannot hold the picture.
bool shape_of(const OIIO::ImageSpec &spec, image_shape &shape, image_message *message)
{
	if (!is_flat(spec, message))
		return false;
	if (spec.nchannels < 1 || spec.nchannels > 4) {
		message_set(message, "it has " + std::to_string(spec.nchannels) + " channels, and 1 to 4 are supported");
		return false;
	}
	shape = {uint32_t(spec.width), uint32_t(spec.height), uint32_t(spec.nchannels), scalar_of(spec.format)};
	return true;
}

// A file in memory. OpenImageIO's own reader (2.4.7) reads before the start of its buffer if a damaged file holds such
// an offset.
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

// A file in memory for OpenImageIO's reader of JPEG (2.4.7), which needs a FILE.
class stream_reader final : public OIIO::Filesystem::IOFile
{
  public:
	stream_reader(FILE *stream, const void *data, size_t size) : IOFile(stream, Read), memory_(data, size)
	{
	}
	size_t pread(void *out, size_t size, int64_t offset) override
	{
		return memory_.pread(out, size, offset); // IOFile's needs a file descriptor
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

image_outcome decode(const char *format, const void *data, size_t size, image_allocate *allocate, void *context,
                     image_message *message)
{
	library_init();
	bounded_reader memory(data, size); // this, stream and file outlive input, which reads through them
	std::unique_ptr<FILE, stream_closer> stream;
	std::unique_ptr<stream_reader> file;
	OIIO::Filesystem::IOProxy *proxy = &memory;
	if (strcmp(format, "jpeg") == 0) {
		stream.reset(fmemopen(const_cast<void *>(data), size, "rb"));
		if (!stream)
			return IMAGE_OUTCOME_MEMORY;
		file = std::make_unique<stream_reader>(stream.get(), data, size);
		proxy = file.get();
	}
	// By the format's name: OpenImageIO's open by path would try every reader on a damaged file.
	auto input = OIIO::ImageInput::create(format);
	if (!input) {
		message_set(message, OIIO::geterror());
		return IMAGE_OUTCOME_CODEC;
	}
	OIIO::ImageSpec spec, config;
	config.attribute("oiio:UnassociatedAlpha", 1);
	image_shape shape;
	if (!input->set_ioproxy(proxy) || !input->open(format, spec, config)) {
		message_set(message, input->geterror());
		return IMAGE_OUTCOME_CODEC;
	}
	if (!shape_of(spec, shape, message))
		return IMAGE_OUTCOME_CODEC;
	void *pixels = allocate(context, &shape);
	if (!pixels)
		return IMAGE_OUTCOME_CALLBACK;
	if (!input->read_image(0, 0, 0, int(shape.channels), type_of(shape.scalar), pixels)) {
		message_set(message, input->geterror());
		return IMAGE_OUTCOME_CODEC;
	}
	return IMAGE_OUTCOME_DONE;
}

// ---- for C ---------------------------------------------------------------------------------------------------------

// Runs body, and converts an exception to an outcome with a message.
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

image_outcome foreign_decode(const char *format, const void *data, size_t size, image_allocate *allocate, void *context,
                             image_message *message)
{
	return guarded(message, [=] { return decode(format, data, size, allocate, context, message); });
}

const char *foreign_version()
{
	static const std::string version = [] {
		int packed = OIIO::openimageio_version(); // 20407 for 2.4.7
		return std::to_string(packed / 10000) + "." + std::to_string(packed / 100 % 100) + "." +
		       std::to_string(packed % 100);
	}();
	return version.c_str();
}

} // namespace

extern "C" __attribute__((visibility("default"))) const image_foreign image_foreign_oiio; // IMAGE_FOREIGN_SYMBOL
const image_foreign image_foreign_oiio = {foreign_decode, foreign_version};
