// SPDX-License-Identifier: Apache-2.0
// What is said to SQLite, and its errors as ours. One caller at a time.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "base/result.h"

struct sqlite3;
struct sqlite3_stmt;

namespace seaway::server {

/// Of the last call. A disk that is full, or does not answer, or another program that holds the file, is no wrong journal: it passes
/// (JournalError::unreachable).
Error sql_error(sqlite3* database);
Result<void> run(sqlite3* database, const char* sql);

/// One prepared statement; its values are bound in order.
class Statement {
  public:
    static Result<Statement> prepare(sqlite3* database, const char* sql);

    Statement& bind(std::int64_t value);
    Statement& bind(const std::string& value);
    /// True: there is a row.
    Result<bool> step();
    // Of that row.
    std::int64_t integer(int column) const;
    std::string text(int column) const;

  private:
    struct Finalize {
        void operator()(sqlite3_stmt* statement) const;
    };
    Statement(sqlite3* database, sqlite3_stmt* statement)
        : database_(database), statement_(statement) {}

    sqlite3* database_;
    std::unique_ptr<sqlite3_stmt, Finalize> statement_;
    int bound_ = 0;
};

/// Of the first row.
Result<std::int64_t> first_number(sqlite3* database, const char* sql);

} // namespace seaway::server
