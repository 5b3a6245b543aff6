// SPDX-License-Identifier: Apache-2.0
// Reads the reference tables of tests/data: '#' lines are notes, then a header, then rows; a field
// in quotes may hold commas.
#pragma once

#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace seaway::testing {

class Table {
  public:
    explicit Table(const std::string& name) {
        std::ifstream file(SEAWAY_SOURCE_DIR "/tests/data/" + name + ".csv");
        for (std::string line; std::getline(file, line);) {
            if (line.empty() || line[0] == '#')
                continue;
            (header_.empty() ? header_ : rows_.emplace_back()) = split(line);
        }
        if (rows_.empty())
            throw std::runtime_error("no rows in reference table " + name);
    }

    std::size_t size() const { return rows_.size(); }
    const std::string& text(std::size_t row, const std::string& column) const {
        for (std::size_t c = 0; c < header_.size(); ++c)
            if (header_[c] == column)
                return rows_.at(row).at(c);
        throw std::runtime_error("no column " + column);
    }
    double number(std::size_t row, const std::string& column) const {
        return std::strtod(text(row, column).c_str(), nullptr);
    }
    /// The row whose first columns hold these texts.
    std::size_t find(const std::string& first, const std::string& second = {}) const {
        for (std::size_t r = 0; r < rows_.size(); ++r)
            if (rows_[r].at(0) == first && (second.empty() || rows_[r].at(1) == second))
                return r;
        throw std::runtime_error("no row " + first + " " + second);
    }
    const std::vector<std::string>& header() const { return header_; }

  private:
    static std::vector<std::string> split(const std::string& line) {
        std::vector<std::string> fields(1);
        bool quoted = false;
        for (const char c : line) {
            if (c == '"')
                quoted = !quoted;
            else if (c == ',' && !quoted)
                fields.emplace_back();
            else if (c != '\r')
                fields.back() += c;
        }
        return fields;
    }

    std::vector<std::string> header_;
    std::vector<std::vector<std::string>> rows_;
};

} // namespace seaway::testing
