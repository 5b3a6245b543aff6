// SPDX-License-Identifier: Apache-2.0
#include "client/view/film_file.h"

#include <cstdio>
#include <filesystem>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "base/whole_file.h"

namespace seaway::client {

namespace {

std::string part_of(const std::string& path) {
    return path + ".part";
}

std::vector<std::string> words_for(const std::string& path, int width, int height, FrameRate rate) {
    std::vector<std::string> words{
        "ffmpeg", "-hide_banner", "-loglevel", "error", "-y", "-f", "rawvideo", "-pixel_format",
        "rgba", "-video_size", fmt::format("{}x{}", width, height), "-framerate", rate.text(), "-i",
        "pipe:0", "-vf",
        // Colours go by 2 x 2; and by BT.709, as players take what is not said, not by BT.601, which
        // ffmpeg takes where nothing is.
        "scale=out_color_matrix=bt709:out_range=tv,pad=ceil(iw/2)*2:ceil(ih/2)*2", "-colorspace",
        "bt709", "-color_primaries", "bt709", "-color_trc", "iec61966-2-1", "-color_range", "tv",
        "-pix_fmt", "yuv420p"};
    const std::vector<std::string> coder =
        path.ends_with(".webm")
            ? std::vector<std::string>{"-c:v", "libvpx-vp9", "-crf", "24", "-b:v", "0"}
            : std::vector<std::string>{"-c:v", "libx264", "-crf", "18", "-movflags", "+faststart"};
    words.insert(words.end(), coder.begin(), coder.end());
    // The part's name does not say what it is to become.
    words.insert(words.end(), {"-f", path.ends_with(".webm") ? "webm" : "mp4"});
    words.push_back("file:" + part_of(path));
    return words;
}

} // namespace

bool is_film(const std::string& path) {
    return path.ends_with(".mp4") || path.ends_with(".webm");
}

Result<FilmFile> FilmFile::open(const std::string& path, int width, int height, FrameRate rate) {
    if (const Result<void> can = check_whole_file(path); !can)
        return Error{"cannot write " + path + ": " + can.error().message};
    Result<ChildProcess> coder = ChildProcess::start(words_for(path, width, height, rate));
    if (coder)
        return FilmFile(path, part_of(path), std::move(*coder));
    const std::string why =
        ChildProcess::is_missing(coder.error())
            ? "films are written by ffmpeg, which is not there: apt install ffmpeg, or give a "
              "pattern of .png files"
            : "cannot start ffmpeg: " + coder.error().message;
    return Error{"cannot write " + path + ": " + why};
}

FilmFile::Part::~Part() {
    if (!path_.empty())
        std::remove(path_.c_str());
}

Result<void> FilmFile::Part::rename(const std::string& path) {
    std::error_code problem;
    std::filesystem::rename(path_, path, problem);
    if (problem)
        return Error{"cannot write " + path + ": " + problem.message()};
    path_.clear();
    return {};
}

Result<void> FilmFile::add(const ShownPicture& picture) {
    if (!coder_.write(picture.rgba))
        return Error{"cannot write " + path_ + ": ffmpeg has ended before the film did"};
    return {};
}

Result<void> FilmFile::close() {
    const ChildProcess::End end = coder_.wait();
    if (!end.by_signal && end.code == 0)
        return part_.rename(path_);
    return Error{fmt::format("cannot write {}: ffmpeg ended with {} {}", path_,
                             end.by_signal ? "signal" : "status", end.code)};
}

} // namespace seaway::client
