// SPDX-License-Identifier: Apache-2.0
#include "server/journal/sqlite_statement.h"

#include <sqlite3.h>

#include "server/journal/journal.h"
#include "server/journal/journal_file.h"

namespace seaway::server {

Error sql_error(sqlite3* database) {
    const int code = sqlite3_errcode(database) & 0xff;
    Error error{sqlite3_errmsg(database)};
    if (code == SQLITE_FULL || code == SQLITE_IOERR || code == SQLITE_BUSY ||
        code == SQLITE_LOCKED || code == SQLITE_NOMEM ||
        (code == SQLITE_CANTOPEN && passes(sqlite3_system_errno(database))))
        error.kind = JournalError::unreachable;
    return error;
}

Result<void> run(sqlite3* database, const char* sql) {
    if (sqlite3_exec(database, sql, nullptr, nullptr, nullptr) != SQLITE_OK)
        return sql_error(database);
    return {};
}

Result<Statement> Statement::prepare(sqlite3* database, const char* sql) {
    sqlite3_stmt* made = nullptr;
    if (sqlite3_prepare_v2(database, sql, -1, &made, nullptr) != SQLITE_OK)
        return sql_error(database);
    return Statement(database, made);
}

Statement& Statement::bind(std::int64_t value) {
    sqlite3_bind_int64(statement_.get(), ++bound_, value);
    return *this;
}

Statement& Statement::bind(const std::string& value) {
    sqlite3_bind_text64(statement_.get(), ++bound_, value.data(), value.size(), SQLITE_TRANSIENT,
                        SQLITE_UTF8);
    return *this;
}

Result<bool> Statement::step() {
    const int code = sqlite3_step(statement_.get());
    if (code != SQLITE_ROW && code != SQLITE_DONE)
        return sql_error(database_);
    return code == SQLITE_ROW;
}

std::int64_t Statement::integer(int column) const {
    return sqlite3_column_int64(statement_.get(), column);
}

std::string Statement::text(int column) const {
    const auto* bytes = sqlite3_column_blob(statement_.get(), column);
    const int count = sqlite3_column_bytes(statement_.get(), column);
    return bytes ? std::string(static_cast<const char*>(bytes), static_cast<std::size_t>(count))
                 : std::string();
}

void Statement::Finalize::operator()(sqlite3_stmt* statement) const {
    sqlite3_finalize(statement);
}

Result<std::int64_t> first_number(sqlite3* database, const char* sql) {
    SEAWAY_TRY_LET(Statement one, Statement::prepare(database, sql));
    SEAWAY_TRY(one.step());
    return one.integer(0);
}

} // namespace seaway::server
