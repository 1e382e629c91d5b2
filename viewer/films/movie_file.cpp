// viewer/films/movie_file.cpp: see movie_file.h.
#include "viewer/films/movie_file.h"

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/interrupt.h"
#include "core/base/output_file.h"
#include "core/base/ownership.h"
#include "core/base/shown_text.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <optional>
#include <poll.h>
#include <spawn.h>
#include <sstream>
#include <string>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

extern char** environ;

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// The program on $PATH.
std::optional<fs::path> findProgram(const char* name) {
    const char* const folders = std::getenv("PATH");
    std::istringstream list(folders ? folders : "");
    for (std::string folder; std::getline(list, folder, ':');)
        if (const fs::path path = fs::path(folder) / name;
            !folder.empty() && ::access(path.c_str(), X_OK) == 0)
            return path;
    return std::nullopt;
}

/// A child process that ends with this object.
class Child {
  public:
    Child(const fs::path& program, const std::vector<std::string>& arguments) {
        std::vector<char*> argv;
        for (const std::string& argument : arguments)
            argv.push_back(const_cast<char*>(argument.c_str()));
        argv.push_back(nullptr);
        std::array<int, 2> ends{};
        if (::pipe2(ends.data(), O_CLOEXEC) != 0)
            throw Error(std::string("ffmpeg: no pipe: ") + std::strerror(errno));
        says_ = FileHandle(ends[0]);
        const FileHandle write(ends[1]);
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
        posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
        posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
        const int failed = ::posix_spawn(&pid_, program.c_str(), &actions, nullptr, argv.data(), environ);
        posix_spawn_file_actions_destroy(&actions);
        if (failed != 0) {
            pid_ = -1;
            throw Error(printable(program.string()) + ": cannot be started: " + std::strerror(failed));
        }
    }
    ~Child() {
        if (pid_ < 0)
            return;
        ::kill(pid_, SIGKILL);
        ::waitpid(pid_, nullptr, 0);
    }
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;

    /// Returns its exit status; `said` gets the end of its output.
    int wait(std::string& said) {
        constexpr std::size_t kMost = 2000;
        for (bool open = true; open;) {
            checkInterrupted();
            pollfd ready{says_.descriptor(), POLLIN, 0};
            if (::poll(&ready, 1, 100) <= 0)
                continue;
            std::array<char, 4096> part{};
            const ssize_t got = ::read(says_.descriptor(), part.data(), part.size());
            open = got > 0;
            said.append(part.data(), static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
            if (said.size() > kMost)
                said.erase(0, said.size() - kMost);
        }
        int status = 0;
        ::waitpid(pid_, &status, 0);
        pid_ = -1;
        return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
    }

  private:
    pid_t pid_ = -1;
    FileHandle says_;
};

std::string lastLine(const std::string& said) {
    std::istringstream lines(said);
    std::string last;
    for (std::string line; std::getline(lines, line);)
        if (line.find_first_not_of(" \t\r") != std::string::npos)
            last = line;
    return last.empty() ? "nothing" : last;
}

} // namespace

bool isMovieFile(const fs::path& path) {
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension == ".mp4" || extension == ".mov" || extension == ".mkv";
}

void checkMovieFile(const fs::path& path) {
    checkOutputFile(path);
    if (!findProgram("ffmpeg"))
        throw badFile(path.string(),
                      "the program ffmpeg, which writes " + path.extension().string() +
                          " files (install the package ffmpeg), or a folder for frames: -o frames/",
                      "no ffmpeg on PATH");
}

void writeMovie(const fs::path& path, const fs::path& folder, std::size_t first, std::size_t count,
                double framesPerSecond) {
    checkMovieFile(path);
    const fs::path target = outputTarget(path);
    // Its extension names the format.
    const fs::path unfinished = target.parent_path() / (temporaryName(target.stem().string(), "tessera", 0) +
                                                        target.extension().string());
    const TemporaryPath temporary(unfinished);
    std::ostringstream rate;
    rate.precision(12);
    rate << framesPerSecond;
    // Players support only even sizes and 4:2:0. Frames are sRGB; the movie states how its colours are coded.
    const std::vector<std::string> arguments = {
        "ffmpeg",
        "-nostdin",
        "-hide_banner",
        "-loglevel",
        "error",
        "-y",
        "-framerate",
        rate.str(),
        "-start_number",
        std::to_string(first),
        "-i",
        (folder / "frame-%06d.png").string(),
        "-frames:v",
        std::to_string(count),
        "-vf",
        "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv,format=yuv420p",
        "-colorspace",
        "bt709",
        "-color_primaries",
        "bt709",
        "-color_trc",
        "iec61966-2-1",
        "-crf", // for encoders that support it; others take the next option
        "17",
        "-q:v",
        "2",
        "-movflags",
        "+faststart",
        unfinished.string()};
    std::string said;
    int status = 0;
    try {
        status = Child(*findProgram("ffmpeg"), arguments).wait(said);
        if (status != 0)
            throw Error(printable(path.string()) + ": ffmpeg failed: " + printable(lastLine(said)));
        if (::rename(unfinished.c_str(), target.c_str()) != 0)
            throw Error(printable(path.string()) + ": cannot be written: " + std::strerror(errno));
    } catch (...) {
        std::error_code ignored;
        fs::remove(unfinished, ignored);
        throw;
    }
}

} // namespace tessera
