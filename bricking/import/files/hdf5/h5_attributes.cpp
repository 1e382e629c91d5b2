// bricking/import/files/hdf5/h5_attributes.cpp: see h5_attributes.h.
#include "bricking/import/files/hdf5/h5_attributes.h"

#include "bricking/import/files/hdf5/h5_set.h"
#include "bricking/import/files/hdf5/h5_tree.h"
#include "bricking/import/files/hdf5/h5_types.h"
#include "bricking/import/source/slice_converter.h"

#include <array>
#include <utility>

namespace tessera {
namespace {

constexpr std::uint64_t kMostNumbers = 64;

struct H5Attribute {
    std::string name;
    H5Type type;
    H5Space space;
    H5Bytes data;
};

H5Bytes partOrShared(H5Bytes& bytes, std::uint64_t size, bool isShared, H5Kind kind) {
    H5Bytes part = bytes.part(size);
    if (!isShared)
        return part;
    if (auto shared = readH5Object(bytes.file(), placeOfShared(part)).find(kind))
        return *shared;
    bytes.refuse("a type at the place that is said", "none");
}

H5Attribute readAttribute(H5Bytes bytes) {
    const int version = bytes.byte();
    bytes.requireVersion(version, 1, 3);
    const int flags = bytes.byte();
    const std::uint64_t step = version == 1 ? 8 : 1;
    std::array<std::uint64_t, 3> sizes{}; // of name, type, extents
    for (std::uint64_t& size : sizes)
        size = (bytes.number(2) + step - 1) / step * step;
    bytes.skip(version == 3 ? 1 : 0); // letters: UTF-8 or ASCII
    const std::string name = H5Bytes::textOf(bytes.take(sizes[0]));
    H5Bytes type = partOrShared(bytes, sizes[1], version > 1 && (flags & 1) != 0, H5Kind::type),
            space = partOrShared(bytes, sizes[2], version > 1 && (flags & 2) != 0, H5Kind::space);
    return {name, readH5Type(type), readH5Space(space), bytes};
}

double numberOf(const H5Type& type, H5Bytes& data) {
    const auto bytes = data.take(type.bytes);
    std::vector<std::byte> slice(bytes.begin(), bytes.end());
    ValueRange range;
    widen(range, *type.number, type.isBig, slice);
    return range.isEmpty() ? 0 : range.least;
}

std::optional<std::vector<double>> numbersOf(const H5Shape& shape, H5Bytes data) {
    const std::uint64_t count = shape.space.count();
    if (!shape.type.number || shape.type.isHalf || count > kMostNumbers ||
        count * shape.type.bytes > data.left())
        return std::nullopt;
    std::vector<double> numbers;
    for (std::uint64_t n = 0; n < count; ++n)
        numbers.push_back(numberOf(shape.type, data));
    return numbers;
}

std::optional<H5Attribute> attributeOf(const H5Object& object, const std::string& name) {
    for (const H5Message& message : object.messages)
        if (message.kind == static_cast<int>(H5Kind::attribute) && !message.isShared)
            if (H5Attribute attribute = readAttribute(message.bytes); attribute.name == name)
                return attribute;
    auto info = object.find(H5Kind::attributeInfo);
    if (!info)
        return std::nullopt;
    info->requireVersion(info->byte(), 0, 0);
    info->skip((info->byte() & 1) != 0 ? 2 : 0);
    const std::uint64_t heapAt = info->address(), names = info->address();
    if (heapAt == kH5Nowhere)
        return std::nullopt;
    H5Heap heap(info->file(), heapAt);
    std::optional<H5Attribute> found;
    constexpr int kByName = 8;
    eachH5Record(info->file(), names, kByName, {}, [&](H5Bytes& record) {
        constexpr int kNotManaged = 0x30, kShared = 2;
        H5Bytes again = record, flags = record;
        flags.skip(heap.idBytes());
        if ((again.byte() & kNotManaged) != 0 || (flags.byte() & kShared) != 0)
            return; // huge ones are none of those that are asked for
        if (H5Attribute attribute = readAttribute(heap.object(record)); attribute.name == name)
            found = std::move(attribute);
    });
    return found;
}

} // namespace

std::optional<std::vector<double>> smallNumbersOf(const H5Object& object) {
    const std::optional<H5Shape> shape = shapeOf(object);
    if (!shape || !shape->type.number || shape->space.count() > kMostNumbers)
        return std::nullopt;
    const H5Set set = readH5Set(object, "a small set");
    if (set.layout.kind == H5Layout::Kind::compact)
        return numbersOf(*shape, *set.layout.compact);
    if (set.layout.kind == H5Layout::Kind::chunked || set.layout.at == kH5Nowhere)
        return std::nullopt;
    const H5Bytes any = object.messages.front().bytes;
    return numbersOf(*shape, any.file().block(set.layout.at, shape->space.count() * shape->type.bytes,
                                              "numbers of a small set"));
}

std::optional<std::vector<double>> numbersAttribute(const H5Object& object, const std::string& name) {
    const std::optional<H5Attribute> attribute = attributeOf(object, name);
    return attribute ? numbersOf({attribute->space, attribute->type}, attribute->data) : std::nullopt;
}

std::optional<std::string> textAttribute(const H5Object& object, const std::string& name) {
    std::optional<H5Attribute> attribute = attributeOf(object, name);
    constexpr std::uint64_t kLongest = 4096;
    if (!attribute || !attribute->type.isText || attribute->type.bytes > kLongest ||
        attribute->space.count() > kLongest)
        return std::nullopt;
    const std::uint64_t bytes = attribute->type.bytes * attribute->space.count();
    return bytes > attribute->data.left() ? std::nullopt
                                          : std::optional(H5Bytes::textOf(attribute->data.take(bytes)));
}

} // namespace tessera
