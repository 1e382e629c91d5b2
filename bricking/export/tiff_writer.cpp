// bricking/export/tiff_writer.cpp: slices as pages of one TIFF file, with spacings in ImageJ's description,
// which this program and Bio-Formats read as well. The format has no place in the patient.
#include "bricking/export/exported_place.h"
#include "bricking/export/exported_values.h"
#include "bricking/export/tiff_pages.h"
#include "bricking/export/volume_writer.h"
#include "core/base/error.h"

#include <array>
#include <string>

namespace tessera {
namespace {

constexpr std::array kTiffTypes = {FileType::u8, FileType::i16, FileType::u16, FileType::f32};

/// ImageJ calibrates whole numbers without a sign by a straight line.
bool keepsRescaleInTiff(const VolumeInfo& info) {
    return info.type == ValueType::u8 || info.type == ValueType::u16;
}

/// Lines of ij.io.FileSaver (ImageJ 1.53).
std::string imageJText(const VolumeInfo& info, bool isCalibrated) {
    const std::string slices = std::to_string(info.extentVoxels.z);
    std::string text = "ImageJ=1.53t\nimages=" + slices + "\nslices=" + slices + "\nunit=mm\n";
    if (isCalibrated)
        text +=
            "cf=0\nc0=" + exactText(info.rescaleIntercept) + "\nc1=" + exactText(info.rescaleSlope) + "\n";
    if (info.unit == "HU")
        text += "vunit=HU\n";
    return text + "spacing=" + exactText(info.spacingMm().z) + "\nloop=false\n";
}

} // namespace

ExportReport writeTiff(BoxSource& box, const ExportRequest& request) {
    const VolumeInfo& info = box.info();
    const bool isRescaled = info.rescaleSlope != 1 || info.rescaleIntercept != 0,
               keeps = isRescaled && keepsRescaleInTiff(info);
    checkOutputFile(request.out, request.existing());
    const ExportedValues values =
        keeps ? storedValues(info) : physicalValues(box, kTiffTypes, request.ram, request.progress);
    const glm::dvec3 mm = info.spacingMm();
    TiffLayout layout{{info.extentVoxels.x, info.extentVoxels.y},
                      info.extentVoxels.z,
                      values.type,
                      {mm.x, mm.y},
                      imageJText(info, keeps),
                      request.compress};
    const Charge charge = request.ram.charge(TiffPages::bytesNeeded(layout), "strips to deflate");
    TiffPages pages(request.out, layout, request.existing());
    request.progress.stage("writing " + request.out.string());
    streamNumbers(box, values, request.ram, request.progress,
                  [&](std::span<const std::byte> numbers) { pages.append(numbers); });
    pages.finish();
    ExportReport report{pages.size(), sayValues(info, values, keeps), {}};
    report.notes.emplace_back("TIFF has spacings alone: the place and the axes in the patient are left out");
    if (placeOf(info).shear() > kMostShear)
        report.notes.emplace_back(
            "the slices are tilted, which TIFF cannot say: they look like a straight stack");
    if (pages.isBig())
        report.notes.emplace_back("more than 4 GiB: a BigTIFF, which ImageJ opens by Bio-Formats");
    return report;
}

} // namespace tessera
