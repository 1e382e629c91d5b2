// tests/bricking/import/damage_corpus.cpp: damages DICOM slices at random and checks the result of import.
//     damage_corpus [RUNS] [SEED]        (2000 runs by default; prints a table; exit 1 for a fault of ours)
// A series of three slices, in every transfer syntax; one slice is damaged in its header or in its pixels.
// Import, in a process of its own, may refuse or give the right voxels. Wrong voxels are a fault wherever
// another reader warns or refuses: DCMTK's tools and opj_decompress, where they are installed (dcmconv makes
// the plain syntaxes besides explicit little endian). Damage that none of them detects cannot be detected; it
// is counted by the part that it hits. DAMAGE_CORPUS_KEEP=FOLDER keeps the series of every fault;
// DAMAGE_CORPUS_VERBOSE=1 lists what none told.
#include "bricking/import/codecs/stream.h"
#include "bricking/import/dicom/encapsulated_frames.h"
#include "bricking/import/open_source.h"
#include "core/base/error.h"
#include "core/base/program_folders.h"
#include "tests/support/dicom_writer.h"
#include "tests/support/stream_writer.h"

#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <map>
#include <random>
#include <sstream>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace tessera::test {
namespace {

namespace fs = std::filesystem;
constexpr int kColumns = 48, kRows = 40;
constexpr unsigned kHangSeconds = 20;
constexpr rlim_t kMostMemory = rlim_t{2} << 30;

struct Coding {
    std::string name, syntax, convert, judge; // dcmconv's option; the DCMTK tool that decodes it
};
const std::vector<Coding> kCodings = {{"explicit little", "1.2.840.10008.1.2.1", "", ""},
                                      {"implicit little", "1.2.840.10008.1.2.1", "+ti", ""},
                                      {"big endian", "1.2.840.10008.1.2.1", "+tb", ""},
                                      {"deflated", "1.2.840.10008.1.2.1", "+td", ""},
                                      {"RLE", "1.2.840.10008.1.2.5", "", "dcmdrle"},
                                      {"JPEG baseline", "1.2.840.10008.1.2.4.50", "", "dcmdjpeg"},
                                      {"JPEG extended", "1.2.840.10008.1.2.4.51", "", "dcmdjpeg"},
                                      {"JPEG lossless", "1.2.840.10008.1.2.4.57", "", "dcmdjpeg"},
                                      {"JPEG lossless SV1", "1.2.840.10008.1.2.4.70", "", "dcmdjpeg"},
                                      {"JPEG-LS", "1.2.840.10008.1.2.4.80", "", "dcmdjpls"},
                                      {"JPEG-LS near", "1.2.840.10008.1.2.4.81", "", "dcmdjpls"},
                                      {"JPEG 2000", "1.2.840.10008.1.2.4.90", "", "opj_decompress"},
                                      {"JPEG 2000 lossy", "1.2.840.10008.1.2.4.91", "", "opj_decompress"}};

bool installed(const std::string& tool) {
    return std::system(("command -v " + tool + " >/dev/null 2>&1").c_str()) == 0;
}

std::vector<std::uint16_t> sliceWords(int z, int bits) {
    std::vector<std::uint16_t> words;
    std::mt19937 random(static_cast<unsigned>(z));
    for (int y = 0; y < kRows; ++y)
        for (int x = 0; x < kColumns; ++x) {
            const double r = std::hypot(x - 23.5, y - 19.5) / 20;
            const double value = r > 0.9 ? 0 : r > 0.75 ? 2800 : 1000 + 150 * std::sin(0.4 * (x + y + z));
            const int word = static_cast<int>(value) + static_cast<int>(random() % 32);
            words.push_back(static_cast<std::uint16_t>(word >> (12 - bits)));
        }
    return words;
}

DicomImage sliceImage(const Coding& coding, int z) {
    DicomImage image;
    image.columns = kColumns;
    image.rows = kRows;
    image.bitsStored = 12;
    image.pixelRepresentation = 0;
    image.position = glm::dvec3(-10, -20, 1.5 * z);
    image.syntax = coding.syntax;
    const bool narrow = coding.name == "JPEG baseline";
    if (narrow)
        image.bitsAllocated = image.bitsStored = 8;
    const auto words = sliceWords(z, image.bitsStored);
    const std::vector<std::int32_t> numbers(words.begin(), words.end());
    if (coding.judge.empty())
        image.pixels = words;
    else if (coding.name == "RLE")
        image.fragments = {encodeRle(words)};
    else if (narrow)
        image.fragments = {encodeJpegLossy8(words, kColumns, kRows)};
    else if (coding.name == "JPEG extended")
        image.fragments = {encodeJpegLossy12(words, kColumns, kRows)};
    else if (coding.judge == "dcmdjpeg")
        image.fragments = {
            encodeJpegLossless(words, kColumns, kRows, coding.name == "JPEG lossless" ? 4 : 1)};
    else if (coding.judge == "dcmdjpls")
        image.fragments = {encodeJpegLs(words, kColumns, kRows, 12, coding.name == "JPEG-LS" ? 0 : 3)};
    else
        image.fragments = {
            encodeJpeg2000(numbers, kColumns, kRows, {.bits = 12, .reversible = coding.name == "JPEG 2000"})};
    return image;
}

std::string readText(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}
void writeText(const fs::path& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
}

/// The result of import: type, extent, affine and all voxels, as bytes; empty: refused.
std::string importAll(const fs::path& folder) {
    try {
        const auto source = openSource(folder, {});
        const VolumeInfo info = source->info();
        std::vector<std::byte> voxels(info.voxelCount() * bytesPerValue(info.type));
        source->readSlices(info.extentVoxels.z, voxels);
        std::string out(reinterpret_cast<const char*>(voxels.data()), voxels.size());
        std::ostringstream place;
        place << name(info.type) << info.unit << info.rescaleSlope << ' ' << info.rescaleIntercept;
        for (int column = 0; column < 4; ++column)
            for (int row = 0; row < 3; ++row)
                place << ' ' << std::lround(1e4 * info.patientFromVoxel[column][row]);
        return out + place.str();
    } catch (const InputError&) {
        return "";
    }
}

enum class Result { refused, right, wrong, crash, hang };

/// Import in a process of its own. The memory is bounded: a lie must not be allocated.
Result tryImport(const fs::path& folder, const std::string& truth) {
    std::fflush(nullptr);
    const pid_t child = ::fork();
    if (child == 0) {
#ifndef __SANITIZE_ADDRESS__ // the sanitizer maps terabytes
        const rlimit limit{kMostMemory, kMostMemory};
        ::setrlimit(RLIMIT_AS, &limit);
#endif
        ::alarm(kHangSeconds);
        try {
            const std::string got = importAll(folder);
            ::_exit(got.empty() ? 0 : got == truth ? 1 : 2);
        } catch (...) { // not an InputError: a bug, or out of memory
            ::_exit(3);
        }
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    if (WIFSIGNALED(status))
        return WTERMSIG(status) == SIGALRM ? Result::hang : Result::crash;
    return WEXITSTATUS(status) > 2 ? Result::crash : static_cast<Result>(WEXITSTATUS(status));
}

struct Damage {
    std::string bytes, words;
};

/// @param begin, end  the bytes that may be hit
Damage damage(const std::string& sound, std::size_t begin, std::size_t end, std::mt19937& random) {
    Damage d{sound, ""};
    const auto place = [&] { return begin + random() % (end - begin); };
    const std::size_t at = place();
    const std::size_t length = std::min<std::size_t>(1 + random() % 40, end - at);
    switch (random() % 8) {
    case 0:
    case 1:
    case 2:
        d.bytes[at] = static_cast<char>(d.bytes[at] ^ (1 << random() % 8));
        d.words = "bit flipped";
        break;
    case 3:
        d.bytes[at] = static_cast<char>(random());
        d.words = "byte overwritten";
        break;
    case 4:
        d.bytes.resize(at);
        d.words = "cut off";
        break;
    case 5:
        std::fill_n(d.bytes.begin() + static_cast<std::ptrdiff_t>(at), length, '\0');
        d.words = "zeros";
        break;
    case 6:
        d.bytes.erase(at, length);
        d.words = "bytes lost";
        break;
    default:
        d.bytes.insert(at, d.bytes.substr(place(), length));
        d.words = "bytes repeated";
    }
    d.words += " at byte " + std::to_string(at);
    return d;
}

/// The compressed stream of a file as it can be found by its marks; empty if it cannot.
std::string streamOf(const std::string& file) {
    const std::size_t begin = file.find("\xff\x4f\xff\x51"), end = file.find("\xfe\xff\xdd\xe0");
    return begin == std::string::npos ? "" : file.substr(begin, end == std::string::npos ? end : end - begin);
}

/// The complaint of other readers about a file: the first warning or refusal, or nothing.
std::string complaint(const Coding& coding, const fs::path& file, const fs::path& scratch) {
    const auto complains = [&](const std::string& tool, const std::string& arguments, bool anyOutput) {
        if (!installed(tool))
            return std::string();
        const fs::path said = scratch / "said";
        const int code = std::system((tool + " " + arguments + " >" + said.string() + " 2>&1").c_str());
        const std::string text = readText(said);
        for (const char* mark : {"W: ", "E: ", "F: ", "WARNING", "ERROR"})
            if (const auto at = text.find(mark); anyOutput && at != std::string::npos)
                return tool + ": " + text.substr(at, text.find('\n', at) - at);
        return code == 0 ? "" : tool + " exits with " + std::to_string(code);
    };
    std::string said = complains("dcmdump", "-ll warn " + file.string(), true);
    if (said.empty() && coding.judge.rfind("dcm", 0) == 0)
        said = complains(coding.judge, file.string() + " " + (scratch / "out.dcm").string(), true);
    if (said.empty() && coding.judge == "opj_decompress") {
        const std::string stream = streamOf(readText(file));
        if (stream.empty())
            return "no stream found";
        writeText(scratch / "s.j2k", stream);
        said = complains("opj_decompress",
                         "-i " + (scratch / "s.j2k").string() + " -o " + (scratch / "s.pgx").string(), true);
    }
    return said;
}

struct Tally {
    int runs = 0, refused = 0, right = 0, untold = 0, silent = 0, crash = 0, hang = 0;
};

int runCorpus(int runs, unsigned seed) {
    const ScratchFolder folder;
    std::mt19937 random(seed);
    std::map<std::string, Tally> tallies;
    std::map<std::string, int> untold;
    int faults = 0;
    const bool canConvert = installed("dcmconv");
    const int codings = static_cast<int>(kCodings.size());
    const int each = std::max(1, (runs + codings - 1) / codings);
    for (const Coding& coding : kCodings) {
        if (!coding.convert.empty() && !canConvert) {
            std::printf("%-18s left out: dcmconv is not installed\n", coding.name.c_str());
            continue;
        }
        const fs::path place = folder / "series";
        fs::remove_all(place);
        fs::create_directories(place);
        for (int z = 0; z < 3; ++z) {
            const fs::path file = place / ("IM000" + std::to_string(z) + ".dcm");
            writeDicom(file, sliceImage(coding, z));
            if (!coding.convert.empty() &&
                std::system(
                    ("dcmconv " + coding.convert + " " + file.string() + " " + file.string()).c_str()))
                return 1;
        }
        const std::string truth = importAll(place);
        const fs::path victim = place / "IM0001.dcm";
        const std::string sound = readText(victim);
        if (truth.empty() || !complaint(coding, victim, folder.path()).empty()) {
            std::printf("%s: the sound series is not: %s\n", coding.name.c_str(),
                        complaint(coding, victim, folder.path()).c_str());
            return 1;
        }
        const std::string little("\xe0\x7f\x10\x00", 4), big("\x7f\xe0\x00\x10", 4);
        const std::size_t pixels = sound.find(coding.convert == "+tb" ? big : little);
        const std::size_t headerEnd =
            pixels == std::string::npos ? sound.size() / 2 : pixels + 12; // deflated
        Tally& tally = tallies[coding.name];
        for (int run = 0; tally.runs < each; ++run) {
            const bool inHeader = run % 2 == 0;
            const Damage hit =
                damage(sound, inHeader ? 0 : headerEnd, inHeader ? headerEnd : sound.size(), random);
            if (hit.bytes == sound)
                continue;
            writeText(victim, hit.bytes);
            ++tally.runs;
            const Result result = tryImport(place, truth);
            tally.refused += result == Result::refused;
            tally.right += result == Result::right;
            tally.crash += result == Result::crash;
            tally.hang += result == Result::hang;
            if (result == Result::refused || result == Result::right)
                continue;
            const std::string said = result == Result::wrong ? complaint(coding, victim, folder.path()) : "";
            const char* const keep = std::getenv("DAMAGE_CORPUS_KEEP");
            if (keep && (result != Result::wrong || !said.empty()))
                fs::copy(place, fs::path(keep) / ("fault-" + std::to_string(++faults)));
            const std::string where = coding.name + (inHeader ? ", header: " : ", pixels: ") + hit.words;
            if (result != Result::wrong || !said.empty())
                std::printf("FAULT %s%s %s\n",
                            result == Result::wrong ? "silent: " : "crash or hang: ", where.c_str(),
                            said.c_str());
            else if (std::getenv("DAMAGE_CORPUS_VERBOSE"))
                std::printf("untold: %s\n", where.c_str());
            if (result == Result::wrong && said.empty()) {
                ++tally.untold;
                ++untold[inHeader ? "header" : coding.judge.empty() ? "plain pixels" : "compressed pixels"];
            }
            tally.silent += result == Result::wrong && !said.empty();
        }
    }
    Tally all;
    std::printf("%-18s %6s %8s %6s %7s %7s %6s %5s\n", "syntax", "runs", "refused", "right", "untold",
                "silent", "crash", "hang");
    const auto print = [](const std::string& label, const Tally& t) {
        std::printf("%-18s %6d %8d %6d %7d %7d %6d %5d\n", label.c_str(), t.runs, t.refused, t.right,
                    t.untold, t.silent, t.crash, t.hang);
    };
    for (const auto& [label, t] : tallies) {
        print(label, t);
        all.runs += t.runs, all.refused += t.refused, all.right += t.right, all.untold += t.untold;
        all.silent += t.silent, all.crash += t.crash, all.hang += t.hang;
    }
    print("all", all);
    for (const auto& [what, count] : untold)
        std::printf("wrong and told by no reader, damage in the %s: %d\n", what.c_str(), count);
    return all.silent + all.crash + all.hang > 0 ? 1 : 0;
}

} // namespace
} // namespace tessera::test

int main(int argc, char** argv) {
    const int runs = argc > 1 ? std::atoi(argv[1]) : 2000;
    const unsigned seed = argc > 2 ? static_cast<unsigned>(std::atoi(argv[2])) : 1;
    return tessera::test::runCorpus(runs, seed);
}
