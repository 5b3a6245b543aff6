// SPDX-License-Identifier: Apache-2.0
// FrameWriter: where drawn frames go: a PNG or EXR each, or all of them into one film; and how far it is. Not thread-safe.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "base/result.h"
#include "client/view/film_file.h"
#include "client/view/picture.h"
#include "client/view/view_options.h"

namespace seaway::client {

class FrameWriter {
  public:
    explicit FrameWriter(const ViewOptions& options);

    /// Are bytes wanted, or numbers (EXR)?
    bool shows() const { return shows_; }
    /// `frame` is its number. Makes missing folders. The path that was written. Errors name it.
    Result<std::string> write(const Picture& picture, int frame, const PictureNotes& notes);
    Result<std::string> write(const ShownPicture& picture, int frame);
    /// The film is whole after this; of single files nothing is left to do.
    Result<void> close();

    /// On a terminal: one line on stderr that is overwritten, frames done and time left.
    void tell(int done);

  private:
    std::string pattern_;
    int frames_;
    bool numbered_;
    FrameRate rate_;
    bool shows_;
    std::optional<FilmFile> film_;
    bool terminal_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

} // namespace seaway::client
