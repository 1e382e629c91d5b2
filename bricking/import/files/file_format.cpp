// bricking/import/files/file_format.cpp: see file_format.h.
#include "bricking/import/files/file_format.h"

#include "bricking/import/source/source_files.h"
#include "core/base/address.h"
#include "core/base/error.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <map>
#include <string_view>

namespace tessera {

namespace {

std::string lowerName(const std::filesystem::path& path) {
    std::string name = path.filename().string();
    std::transform(name.begin(), name.end(), name.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return name;
}

} // namespace

const FileFormat* fileFormatOf(const std::filesystem::path& file) {
    std::error_code none;
    if (isAddress(file) || std::filesystem::is_directory(file, none)) {
        for (const FileFormat& format : fileFormats())
            if (format.isFolder && format.isFolder(file))
                return &format;
        return nullptr;
    }
    const std::string name = lowerName(file);
    const FileFormat* best = nullptr;
    std::size_t longest = 0;
    for (const FileFormat& format : fileFormats())
        for (const std::string& ending : format.endings)
            if (name.size() > ending.size() && ending.size() > longest && name.ends_with(ending)) {
                best = &format;
                longest = ending.size();
            }
    return best;
}

std::string withFormats(const std::string& first, std::string FileFormat::*text) {
    std::string all = first;
    for (const FileFormat& format : fileFormats())
        if (!(format.*text).empty())
            all += ", " + format.*text;
    const std::size_t last = all.rfind(", ");
    return last == std::string::npos ? all : all.replace(last, 2, " or ");
}

const FileFormat* stackFormatOf(const std::filesystem::path& file) {
    const std::string name = lowerName(file);
    for (const FileFormat& format : fileFormats())
        for (const std::string& ending : format.sliceEndings)
            if (format.openStack && name.size() > ending.size() && name.ends_with(ending))
                return &format;
    return nullptr;
}

BadFile spacingUnknown(const std::string& path, const std::string& found) {
    return badFile(path, "the spacing of voxels, or --spacing X,Y,Z (mm) where the file does not say it",
                   found);
}

namespace {

namespace fs = std::filesystem;

const std::string kToNifti = "convert it to .nii.gz, for example with 3D Slicer or c3d";

std::string firstBytes(const fs::path& file, std::size_t count) {
    try {
        std::string bytes(count, '\0');
        bytes.resize(InputFile(file).readSome(0, std::as_writable_bytes(std::span(bytes))));
        return bytes;
    } catch (const Error&) {
        return "";
    }
}

ForeignFormat foreignFolder(const fs::path& folder) {
    std::error_code none;
    const auto has = [&](const char* name) { return fs::is_regular_file(folder / name, none); };
    if (has("zarr.json") || has(".zgroup") || has(".zattrs") || has(".zarray"))
        return {};
    std::string name = lowerName(folder.has_filename() ? folder : folder.parent_path());
    if (name.ends_with(".zarr"))
        return {"a .zarr folder without metadata (no zarr.json)",
                "is it an unfinished copy? Copy or import it again"};
    return {};
}

struct Ending {
    const char* ending;
    const char* what;
    int advice; // 0 none, 1 to NIfTI, 2 unpack
};
constexpr std::array kEndings = {
    Ending{".hdr", "an Analyze or detached NIfTI header (.hdr/.img)", 1},
    Ending{".img", "the data of an Analyze or detached NIfTI volume (.hdr/.img)", 1},
    Ending{".mgz", "a FreeSurfer volume", 1},
    Ending{".mgh", "a FreeSurfer volume", 1},
    Ending{".mnc", "a MINC volume", 1},
    Ending{".vtk", "a VTK file", 1},
    Ending{".zip", "a ZIP archive", 2},
    Ending{".tar", "a tar archive", 2},
    Ending{".tgz", "a tar archive", 2},
    Ending{".tar.gz", "a tar archive", 2},
    Ending{".7z", "a 7-Zip archive", 2},
    Ending{".rar", "a RAR archive", 2},
    Ending{".stl", "a surface mesh", 0},
    Ending{".ply", "a surface mesh", 0},
    Ending{".obj", "a surface mesh", 0}};

ForeignFormat made(const char* what, int advice) {
    return {what, advice == 1 ? kToNifti : advice == 2 ? "unpack it and name the folder" : ""};
}

ForeignFormat foreignFile(const fs::path& file) {
    const std::string head = firstBytes(file, 348);
    const std::string_view bytes = head;
    if (bytes.starts_with("PK\x03\x04"))
        return made("a ZIP archive", 2);
    if (bytes.starts_with("NRRD0"))
        return made("an NRRD volume under another name: call it .nrrd", 0);
    if (bytes.starts_with("ObjectType = Image"))
        return made("a MetaImage header under another name: call it .mhd", 0);
    if (bytes.starts_with("\x89HDF"))
        return made("an HDF5 file under another name: call it .h5", 0);
    if (bytes.starts_with("# vtk DataFile"))
        return made("a VTK file", 1);
    const std::string name = lowerName(file);
    if (name.ends_with(".vol"))
        return {"the voxels of a Volume Graphics volume", "open its header (.vgi)"};
    if (bytes.starts_with("\x1f\x8b"))
        return made(
            name.find(".dcm") != std::string::npos ? "a DICOM file packed with gzip" : "a gzip archive", 2);
    if (name == "dicomdir")
        return {"a DICOMDIR, the index of a disc", "name the folder that it lies in"};
    if (name == ".zarray" || name == ".zgroup" || name == "zarr.json")
        return {"the metadata of a Zarr", "name its folder"};
    for (const Ending& row : kEndings)
        if (name.ends_with(row.ending))
            return made(row.what, row.advice);
    if (bytes.starts_with("\xff\x4f\xff\x51") || bytes.starts_with(std::string_view("\0\0\0\x0cjP  ", 8)))
        return {"a JPEG 2000 picture", "slices in such files are opened by their folder"};
    if (bytes.starts_with("\x89PNG") || bytes.starts_with("\xff\xd8\xff") || bytes.starts_with("%PDF"))
        return {"a picture or document",
                bytes.starts_with("\x89PNG") ? "slices in PNG files are opened by their folder" : ""};
    if (bytes.size() == 348 && (bytes.substr(0, 4) == std::string_view("\x5c\x01\0\0", 4) ||
                                bytes.substr(0, 4) == std::string_view("\0\0\x01\x5c", 4)))
        return made(bytes.substr(344, 2) == "n+" ? "a NIfTI volume under another name: call it .nii"
                                                 : "an Analyze or detached NIfTI header (.hdr/.img)",
                    bytes.substr(344, 2) == "n+" ? 0 : 1);
    return {};
}

} // namespace

ForeignFormat foreignFormatOf(const fs::path& path) {
    std::error_code none;
    return fs::is_directory(path, none) ? foreignFolder(path) : foreignFile(path);
}

std::string countForeign(const std::vector<fs::path>& files) {
    constexpr std::size_t kMostNames = 3, kMostLookedAt = 1000; // bytes are read of each
    std::map<std::string, std::vector<fs::path>> kinds;
    std::string advice;
    for (std::size_t i = 0; i < std::min(files.size(), kMostLookedAt); ++i)
        if (const ForeignFormat format = foreignFormatOf(files[i]); format.known()) {
            kinds[format.what].push_back(files[i]);
            if (advice.empty())
                advice = format.advice;
        }
    std::string text;
    for (const auto& [what, named] : kinds) {
        text += (text.empty() ? "" : ", ") + what;
        for (std::size_t i = 0; i < std::min(named.size(), kMostNames); ++i)
            text += (i == 0 ? " (" : ", ") + printableName(named[i].filename());
        text +=
            named.size() > kMostNames ? " and " + std::to_string(named.size() - kMostNames) + " more)" : ")";
    }
    return text.empty() || advice.empty() ? text : text + ": " + advice;
}

} // namespace tessera
