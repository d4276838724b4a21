#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace sgraph {

enum class Access {
  read,    ///< of a file that is there; it is not changed
  write,   ///< of a file that is there
  create,  ///< of a new file, or one that is there
};

/// A connection to an SQLite file. One thread at a time. Everything throws StoreError with the file's name and the reason.
class Database {
 public:
  Database(const std::string& path, Access access);
  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  /// Runs statements without results.
  void execute(const std::string& sql);
  /// First column of the first row, as a number; 0 without a row.
  std::int64_t number(const std::string& sql);
  /// The same as a text.
  std::string text(const std::string& sql);
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] sqlite3* handle() const { return handle_; }
  /// Throws the error that SQLite reports by this code.
  [[noreturn]] void fail(int code) const;

 private:
  std::string path_;
  sqlite3* handle_ = nullptr;
};

/// A prepared statement. Values are bound from 1, columns count from 0.
class Statement {
 public:
  Statement(Database& database, const std::string& sql);
  ~Statement();
  Statement(Statement&& other) noexcept;
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  Statement& bind(int index, std::int64_t value);
  Statement& bind(int index, const std::string& text);
  Statement& bind_blob(int index, std::string_view bytes);  ///< copied
  /// True while there is a row.
  bool step();
  /// Runs a statement without rows and makes it ready for the next values.
  void run();
  void reset();

  [[nodiscard]] std::int64_t integer(int column) const;
  [[nodiscard]] std::string text(int column) const;
  [[nodiscard]] std::string_view blob(int column) const;  ///< valid until the next step

 private:
  Database* database_;
  sqlite3_stmt* handle_ = nullptr;
};

/// Begins at construction; rolled back unless committed.
class DatabaseTransaction {
 public:
  explicit DatabaseTransaction(Database& database);
  ~DatabaseTransaction();
  DatabaseTransaction(const DatabaseTransaction&) = delete;
  DatabaseTransaction& operator=(const DatabaseTransaction&) = delete;
  void commit();

 private:
  Database& database_;
  bool open_ = true;
};

}  // namespace sgraph
