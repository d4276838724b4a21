#include "database.hpp"

#include <sqlite3.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "sgraph_slam/core/store/store_error.hpp"

namespace sgraph {
namespace {

constexpr int busy_timeout = 5000;  // [ms] to wait for another process that has the file

const char* reason(int code) {
  switch (code & 0xff) {
    case SQLITE_FULL: return "no space is left on the disk";
    case SQLITE_READONLY: return "the file or its folder is read-only";
    case SQLITE_CANTOPEN: return "it cannot be opened";
    case SQLITE_NOTADB: return "it is no map file, or a damaged one";
    case SQLITE_CORRUPT: return "the file is damaged";
    case SQLITE_BUSY:
    case SQLITE_LOCKED: return "another program is writing it";
    case SQLITE_IOERR: return "reading or writing the disk failed";
    case SQLITE_NOMEM: return "no memory is left";
    case SQLITE_PERM:
    case SQLITE_AUTH: return "permission is denied";
    default: return nullptr;
  }
}

}  // namespace

Database::Database(const std::string& path, Access access) : path_(path) {
  const bool there = std::filesystem::is_regular_file(path);
  if (access != Access::create && !there) throw StoreError(path + ": there is no such file");
  const int flags = access == Access::read    ? SQLITE_OPEN_READONLY
                    : access == Access::write ? SQLITE_OPEN_READWRITE
                                              : SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
  int code = sqlite3_open_v2(path.c_str(), &handle_, flags | SQLITE_OPEN_FULLMUTEX, nullptr);
  if (code == SQLITE_OK && access == Access::read) {
    // A file in WAL mode in a folder that cannot be written is read as it is.
    code = sqlite3_exec(handle_, "SELECT count(*) FROM sqlite_master", nullptr, nullptr, nullptr);
    if ((code & 0xff) == SQLITE_CANTOPEN || (code & 0xff) == SQLITE_READONLY) {
      sqlite3_close(handle_);
      handle_ = nullptr;
      std::string uri = "file:";
      for (const char c : path)
        uri +=
            c == '?' || c == '#' || c == '%' ? std::string("%") + "0123456789ABCDEF"[(c >> 4) & 15] + "0123456789ABCDEF"[c & 15] : std::string(1, c);
      code = sqlite3_open_v2((uri + "?immutable=1").c_str(), &handle_, flags | SQLITE_OPEN_FULLMUTEX | SQLITE_OPEN_URI, nullptr);
    }
  }
  if (code != SQLITE_OK) {
    const char* words = reason(code);
    std::string text = path + ": " + (words != nullptr ? words : handle_ != nullptr ? sqlite3_errmsg(handle_) : "no memory is left");
    sqlite3_close(handle_);
    throw StoreError(text);
  }
  sqlite3_busy_timeout(handle_, busy_timeout);
  sqlite3_extended_result_codes(handle_, 1);
}

Database::~Database() { sqlite3_close(handle_); }

void Database::fail(int code) const {
  const char* words = reason(code);
  throw StoreError(path_ + ": " + (words != nullptr ? words : sqlite3_errmsg(handle_)));
}

void Database::execute(const std::string& sql) {
  const int code = sqlite3_exec(handle_, sql.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) fail(code);
}

std::int64_t Database::number(const std::string& sql) {
  Statement statement(*this, sql);
  return statement.step() ? statement.integer(0) : 0;
}

std::string Database::text(const std::string& sql) {
  Statement statement(*this, sql);
  return statement.step() ? statement.text(0) : std::string();
}

Statement::Statement(Database& database, const std::string& sql) : database_(&database) {
  const int code = sqlite3_prepare_v2(database.handle(), sql.c_str(), -1, &handle_, nullptr);
  if (code != SQLITE_OK) database.fail(code);
}

Statement::~Statement() { sqlite3_finalize(handle_); }

Statement::Statement(Statement&& other) noexcept : database_(other.database_), handle_(other.handle_) { other.handle_ = nullptr; }

Statement& Statement::bind(int index, std::int64_t value) {
  const int code = sqlite3_bind_int64(handle_, index, value);
  if (code != SQLITE_OK) database_->fail(code);
  return *this;
}

Statement& Statement::bind(int index, const std::string& text) {
  const int code = sqlite3_bind_text(handle_, index, text.data(), static_cast<int>(text.size()), SQLITE_TRANSIENT);
  if (code != SQLITE_OK) database_->fail(code);
  return *this;
}

Statement& Statement::bind_blob(int index, std::string_view bytes) {
  const int code = sqlite3_bind_blob(handle_, index, bytes.data() != nullptr ? bytes.data() : "", static_cast<int>(bytes.size()), SQLITE_TRANSIENT);
  if (code != SQLITE_OK) database_->fail(code);
  return *this;
}

bool Statement::step() {
  const int code = sqlite3_step(handle_);
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  sqlite3_reset(handle_);
  database_->fail(code);
}

void Statement::run() {
  step();
  reset();
}

void Statement::reset() { sqlite3_reset(handle_); }

std::int64_t Statement::integer(int column) const { return sqlite3_column_int64(handle_, column); }

std::string Statement::text(int column) const {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(handle_, column));
  return text != nullptr ? std::string(text, static_cast<std::size_t>(sqlite3_column_bytes(handle_, column))) : std::string();
}

std::string_view Statement::blob(int column) const {
  const auto* bytes = static_cast<const char*>(sqlite3_column_blob(handle_, column));
  return bytes != nullptr ? std::string_view(bytes, static_cast<std::size_t>(sqlite3_column_bytes(handle_, column))) : std::string_view();
}

DatabaseTransaction::DatabaseTransaction(Database& database) : database_(database) { database_.execute("BEGIN IMMEDIATE"); }

DatabaseTransaction::~DatabaseTransaction() {
  if (open_) sqlite3_exec(database_.handle(), "ROLLBACK", nullptr, nullptr, nullptr);
}

void DatabaseTransaction::commit() {
  database_.execute("COMMIT");
  open_ = false;
}

}  // namespace sgraph
