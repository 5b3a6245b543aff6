// SPDX-License-Identifier: Apache-2.0
// FilmFile: shown pictures become a film, .mp4 (H.264) or .webm (VP9), by Debian's ffmpeg as a process beside us.
// A film that is not closed is given up. Not thread-safe.
#pragma once

#include <string>
#include <utility>

#include "base/child_process.h"
#include "base/result.h"
#include "client/view/picture.h"

namespace seaway::client {

/// Does this path ask for a film?
bool is_film(const std::string& path);

class FilmFile {
  public:
    /// An error: there is no ffmpeg (it says which package has it), or it cannot be started.
    static Result<FilmFile> open(const std::string& path, int width, int height,
                                 int frames_a_second);
    /// All of the same size. Waits until ffmpeg has taken it. An error: it has ended; its own words are on stderr.
    Result<void> add(const ShownPicture& picture);
    /// The film is whole once this returns.
    Result<void> close();

  private:
    FilmFile(std::string path, ChildProcess coder)
        : path_(std::move(path)), coder_(std::move(coder)) {}

    std::string path_;
    ChildProcess coder_;
};

} // namespace seaway::client
