// SPDX-License-Identifier: Apache-2.0
#include "client/view/frame_writer.h"

#include <cstdio>
#include <filesystem>

#include <fmt/format.h>

#include "base/elapsed.h"
#include "base/messages.h"

namespace seaway::client {

namespace {

Result<void> make_folder_of(const std::string& path) {
    const std::filesystem::path folder = std::filesystem::path(path).parent_path();
    std::error_code failure;
    if (!folder.empty())
        std::filesystem::create_directories(folder, failure);
    if (failure)
        return Error{fmt::format("cannot make folder {}: {}", folder.string(), failure.message())};
    return {};
}

} // namespace

FrameWriter::FrameWriter(const ViewOptions& options)
    : pattern_(options.out), frames_(options.frames), numbered_(options.numbered()),
      rate_(options.rate), shows_(!options.out.ends_with(".exr")),
      terminal_(options.frames > 1 && stderr_is_terminal()) {}

Result<std::string> FrameWriter::write(const Picture& picture, int frame,
                                       const PictureNotes& notes) {
    const std::string path = frame_path(pattern_, frame, numbered_);
    SEAWAY_TRY(make_folder_of(path));
    SEAWAY_TRY(write_exr(picture, path, notes));
    return path;
}

Result<std::string> FrameWriter::write(const ShownPicture& picture, int frame) {
    if (!is_film(pattern_)) {
        const std::string path = frame_path(pattern_, frame, numbered_);
        SEAWAY_TRY(make_folder_of(path));
        SEAWAY_TRY(write_png(picture, path));
        return path;
    }
    if (!film_) {
        SEAWAY_TRY(make_folder_of(pattern_));
        Result<FilmFile> film = FilmFile::open(pattern_, picture.width, picture.height, rate_);
        if (!film)
            return film.error();
        film_.emplace(std::move(*film));
    }
    SEAWAY_TRY(film_->add(picture));
    return pattern_;
}

Result<void> FrameWriter::close() {
    return film_ ? film_->close() : Result<void>();
}

void FrameWriter::tell(int done) {
    if (!terminal_)
        return;
    const double spent_s = seconds_since(start_);
    const double left_s = spent_s / done * (frames_ - done);
    fmt::print(stderr, "\r{}/{} frames, {:.0f} s left\x1b[K{}", done, frames_, left_s,
               done == frames_ ? "\n" : "");
    std::fflush(stderr);
}

} // namespace seaway::client
