// SPDX-License-Identifier: Apache-2.0
// FilmFile: shown pictures become a film, .mp4 (H.264) or .webm (VP9), by Debian's ffmpeg as a process beside us.
// Until it is whole it is PATH.part, and what lies under its name stays; a film that is not closed is given up, and its part
// removed. Not thread-safe.
#pragma once

#include <string>
#include <utility>

#include "base/child_process.h"
#include "base/result.h"
#include "client/view/frame_times.h"
#include "client/view/picture.h"

namespace seaway::client {

/// Does this path ask for a film?
bool is_film(const std::string& path);

class FilmFile {
  public:
    /// An error: there cannot be such a file; there is no ffmpeg (it says which package has it), or it cannot be started.
    static Result<FilmFile> open(const std::string& path, int width, int height, FrameRate rate);
    /// All of the same size. Waits until ffmpeg has taken it. An error: it has ended; its own words are on stderr.
    Result<void> add(const ShownPicture& picture);
    /// The film is whole once this returns.
    Result<void> close();

  private:
    /// Goes when the coder has ended.
    class Part {
      public:
        explicit Part(std::string path) : path_(std::move(path)) {}
        Part(Part&& other) noexcept : path_(std::exchange(other.path_, "")) {}
        Part(const Part&) = delete;
        Part& operator=(const Part&) = delete;
        ~Part();
        Result<void> rename(const std::string& path);

      private:
        std::string path_; ///< empty: there is none
    };
    FilmFile(std::string path, std::string part, ChildProcess coder)
        : path_(std::move(path)), part_(std::move(part)), coder_(std::move(coder)) {}

    std::string path_;
    Part part_; ///< outlives the coder
    ChildProcess coder_;
};

} // namespace seaway::client
