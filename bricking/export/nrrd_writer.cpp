// bricking/export/nrrd_writer.cpp: NRRD files, raw or gzip, in one file with the header. Rules: teem's
// "Definition of NRRD File Format". The format has no slope and intercept, so values are physical ones.
#include "bricking/export/exported_place.h"
#include "bricking/export/exported_values.h"
#include "bricking/export/volume_file.h"
#include "bricking/export/volume_writer.h"

#include <array>
#include <optional>

namespace tessera {
namespace {

constexpr std::array kNrrdTypes = {FileType::u8, FileType::i16, FileType::u16, FileType::i32, FileType::f32};

std::string nrrdHeader(const VolumeInfo& info, const ExportedValues& values, bool isPacked) {
    const ExportedPlace place = placeOf(info);
    const glm::ivec3 n = info.extentVoxels;
    const auto vector = [](const glm::dvec3& v) { return "(" + exactText(v, ",") + ")"; };
    std::string text = "NRRD0005\n";
    text += std::string("type: ") + (values.type == FileType::f32 ? "float" : name(values.type)) + "\n";
    text += "dimension: 3\n";
    text += info.orientationKnown ? "space: left-posterior-superior\n" : "space dimension: 3\n";
    text += "sizes: " + std::to_string(n.x) + " " + std::to_string(n.y) + " " + std::to_string(n.z) + "\n";
    text += "space directions: " + vector(place.step[0]) + " " + vector(place.step[1]) + " " +
            vector(place.step[2]) + "\n";
    text += "kinds: domain domain domain\n";
    text += "endian: little\n";
    text += std::string("encoding: ") + (isPacked ? "gzip" : "raw") + "\n";
    text += "space units: \"mm\" \"mm\" \"mm\"\n";
    text += "space origin: " + vector(place.firstCentre) + "\n";
    if (!info.unit.empty())
        text += "sample units: " + info.unit + "\n";
    return text + "\n";
}

} // namespace

ExportReport writeNrrd(BoxSource& box, const ExportRequest& request) {
    const VolumeInfo& info = box.info();
    VolumeFile file(request.out, request.existing());
    const ExportedValues values = physicalValues(box, kNrrdTypes, request.ram, request.progress);
    file.append(nrrdHeader(info, values, request.compress));
    std::optional<DeflateStream> packed;
    if (request.compress)
        packed.emplace(file, DeflateStream::Wrapper::gzip);
    request.progress.stage("writing " + request.out.string());
    streamNumbers(box, values, request.ram, request.progress, [&](std::span<const std::byte> numbers) {
        packed ? packed->append(numbers) : file.append(numbers);
    });
    if (packed)
        packed->finish();
    file.finish();
    return {file.size(), sayValues(info, values, false), {}};
}

} // namespace tessera
