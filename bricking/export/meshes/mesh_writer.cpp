// bricking/export/meshes/mesh_writer.cpp: see mesh_writer.h.
#include "bricking/export/meshes/mesh_writer.h"

#include "bricking/export/meshes/mesh_form.h"
#include "bricking/import/source/source_files.h" // SpoolFile
#include "core/base/error.h"
#include "core/base/interrupt.h"
#include "core/base/names.h"
#include "core/base/output_file.h"

#include <algorithm>
#include <bit>
#include <cctype>
#include <glm/common.hpp>
#include <limits>
#include <span>

namespace tessera {
namespace {

namespace fs = std::filesystem;
static_assert(std::endian::native == std::endian::little, "numbers are written as they lie in memory");
constexpr const MeshForm* kMeshForms[] = {&kPlyForm, &kStlForm, &kObjForm, &kGlbForm};
constexpr std::size_t kBufferBytes = 1u << 20, kLongestAbout = 160;

const MeshForm* formOf(const fs::path& file) {
    std::string ending = file.extension().string();
    std::ranges::transform(ending, ending.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const auto* const found =
        std::ranges::find_if(kMeshForms, [&](const MeshForm* form) { return ending == form->ending; });
    return found == std::end(kMeshForms) ? nullptr : *found;
}

const MeshForm& requiredForm(const fs::path& file) {
    const MeshForm* const form = formOf(file);
    if (!form)
        throw badFile(file.string(), "a mesh to write that ends in " + joinNames(meshFileEndings()),
                      "\"" + file.extension().string() + "\"");
    return *form;
}

fs::path folderOf(const fs::path& file) {
    const fs::path target = outputTarget(file);
    return target.has_parent_path() ? target.parent_path() : fs::path(".");
}

std::string plainAbout(std::string about) {
    std::ranges::replace_if(
        about, [](char c) { return c < ' ' || c > '~'; }, '?');
    about.resize(std::min(about.size(), kLongestAbout));
    return about;
}

} // namespace

struct MeshWriter::State {
    State(const fs::path& path, const std::string& about, MemoryBudget& ram, Existing existing)
        : shown(path), form(requiredForm(path)),
          charge(ram.charge(3 * kBufferBytes, "buffers of " + path.filename().string())),
          file(path, existing), spool(folderOf(path)) {
        written.about = plainAbout(about);
        written.low = glm::vec3(std::numeric_limits<float>::infinity());
        written.high = -written.low;
        points.reserve(kBufferBytes), triangles.reserve(kBufferBytes);
    }
    void flushPoints() {
        file.writeAt(form.headBytes + written.pointBytes, std::as_bytes(std::span(points)));
        written.pointBytes += points.size();
        points.clear();
        refuseTooMuch();
    }
    void flushTriangles() {
        spool.append(std::as_bytes(std::span(triangles)));
        written.triangleBytes += triangles.size();
        triangles.clear();
        refuseTooMuch();
    }
    void refuseTooMuch() const {
        const std::uint64_t bytes = form.headBytes + written.pointBytes + written.triangleBytes;
        if (bytes > form.mostBytes)
            throw InputError(shown.string() + ": the mesh has more than the " + formatBytes(form.mostBytes) +
                             " that a " + form.ending + " file can hold: a .ply file can hold it");
        if (written.triangles > form.mostTriangles)
            throw InputError(shown.string() + ": the mesh has more than the " +
                             std::to_string(form.mostTriangles) + " triangles that a " + form.ending +
                             " file can hold: a .ply file can hold it");
    }

    fs::path shown;
    const MeshForm& form;
    Charge charge;
    OutputFile file;
    SpoolFile spool;
    WrittenMesh written;
    std::string points, triangles; // not yet written
};

std::vector<std::string> meshFileEndings() {
    std::vector<std::string> endings;
    for (const MeshForm* form : kMeshForms)
        endings.emplace_back(form->ending);
    return endings;
}

void checkMeshFile(const fs::path& file, Existing existing) {
    requiredForm(file);
    checkOutputFile(file, existing);
}

MeshWriter::MeshWriter(const fs::path& file, const std::string& about, MemoryBudget& ram, Existing existing)
    : state_(std::make_unique<State>(file, about, ram, existing)) {}
MeshWriter::~MeshWriter() = default;

void MeshWriter::point(const glm::dvec3& mm) {
    State& s = *state_;
    const glm::vec3 place(mm);
    s.written.low = glm::min(s.written.low, place), s.written.high = glm::max(s.written.high, place);
    ++s.written.points;
    s.form.point(place, s.points);
    if (s.points.size() > kBufferBytes - 256)
        s.flushPoints();
}

void MeshWriter::triangle(const std::array<std::uint32_t, 3>& numbers,
                          const std::array<glm::dvec3, 3>& places) {
    State& s = *state_;
    ++s.written.triangles;
    s.form.triangle(numbers, {glm::vec3(places[0]), glm::vec3(places[1]), glm::vec3(places[2])}, s.triangles);
    if (s.triangles.size() > kBufferBytes - 256)
        s.flushTriangles();
}

std::uint64_t MeshWriter::finish() {
    State& s = *state_;
    s.flushPoints();
    s.flushTriangles();
    std::string& part = s.points; // as a buffer
    const std::uint64_t first = s.form.headBytes + s.written.pointBytes;
    for (std::uint64_t at = 0; at < s.written.triangleBytes; at += part.size()) {
        checkInterrupted();
        part.resize(
            static_cast<std::size_t>(std::min<std::uint64_t>(kBufferBytes, s.written.triangleBytes - at)));
        s.spool.readAt(at, std::as_writable_bytes(std::span(part)));
        s.file.writeAt(first + at, std::as_bytes(std::span(part)));
    }
    const std::string head = s.form.head(s.written);
    TESSERA_CHECK(head.size() == s.form.headBytes);
    s.file.writeAt(0, std::as_bytes(std::span(head)));
    s.file.finish();
    return first + s.written.triangleBytes;
}

} // namespace tessera
