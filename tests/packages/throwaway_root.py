"""A bare Debian root in a folder, made of what this machine has installed: no network, some seconds.

It holds the essential packages, those that are named and all that they depend on - the files that dpkg lists and
its own records of them -, and nothing else: what a package installed there needs, it must have said. Root alone can
make and enter one: `refusal()` says why where it cannot.
"""
import os
import pathlib
import re
import shutil
import subprocess

MERGED = ("bin", "sbin", "lib", "lib32", "lib64", "libx32")  # links into usr since Debian 12


def refusal():
    """Why there can be no such root here; None where there can."""
    if os.geteuid() != 0:
        return "only root may make and enter one"
    if not shutil.which("dpkg-query") or not shutil.which("chroot"):
        return "this is no Debian"
    tried = subprocess.run(["chroot", "/", "true"], capture_output=True, text=True)
    return None if tried.returncode == 0 else tried.stderr.strip()


def query(field, *packages):
    return subprocess.run(["dpkg-query", "-W", "-f", field, *packages], check=True, capture_output=True,
                          text=True).stdout


def names(line):
    """Of "a (>= 1) | b:any, c": [["a", "b"], ["c"]]."""
    return [[re.match(r"[\w.+-]+", name.strip()).group(0) for name in one.split("|")]
            for one in line.split(",") if one.strip()]


class Installed:
    """What this machine has installed: depends, and who provides what."""

    def __init__(self):
        self.depends, self.providers, self.essential = {}, {}, []
        fields = "${Package}\t${db:Status-Status}\t${Essential}\t${Pre-Depends}, ${Depends}\t${Provides}\n"
        for line in query(fields).splitlines():
            package, status, essential, depends, provides = line.split("\t")
            if status != "installed":
                continue
            self.depends[package] = names(depends)
            self.essential += [package] if essential == "yes" else []
            for provided in [package, *(name for one in names(provides) for name in one)]:
                self.providers.setdefault(provided, package)

    def closure(self, wanted):
        """The packages and all that they depend on; of names with "|" between them the first that is here."""
        found, open_ends = set(), [[name] for name in wanted]
        while open_ends:
            alternatives = open_ends.pop()
            package = next((self.providers[name] for name in alternatives if name in self.providers), None)
            if not package:
                raise LookupError(f"this machine has none of: {', '.join(alternatives)}")
            if package not in found:
                found.add(package)
                open_ends += self.depends[package]
        return found


class Root:
    """A folder that chroot can enter. `wanted`: names of packages besides the essential ones."""

    def __init__(self, folder, wanted):
        self.folder = pathlib.Path(folder)
        self.folder.chmod(0o755)  # others than root live in it
        installed = Installed()
        self.packages = sorted(installed.closure([*installed.essential, "dpkg", *wanted]))
        for name in MERGED:
            if os.path.islink(f"/{name}"):
                (self.folder / "usr" / name).mkdir(parents=True, exist_ok=True)
                os.symlink(f"usr/{name}", self.folder / name)
        self._copy_files()
        self._copy_records()
        self._link_alternatives()
        self._make_etc()

    def run(self, *command, user=None, **options):
        """A command inside, with an environment of its own; output is text."""
        enter = ["chroot", *([f"--userspec={user}:{user}"] if user else []), self.folder]
        return subprocess.run([*enter, *command], capture_output=True, text=True,
                              env=self.environment(), **options)

    def start(self, *command, user, **options):
        return subprocess.Popen(["chroot", f"--userspec={user}:{user}", self.folder, *command], text=True,
                                env=self.environment(), **options)

    @staticmethod
    def environment():
        return {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/", "DEBIAN_FRONTEND": "noninteractive",
                "LC_ALL": "C.UTF-8"}

    def files(self):
        """All paths but those that programs write as they run."""
        return {str(path.relative_to(self.folder)) for path in self.folder.rglob("*")
                if not str(path.relative_to(self.folder)).startswith(("var/", "tmp/", "etc/", "run/"))}

    def _copy_files(self):
        listed = subprocess.run(["dpkg-query", "-L", *self.packages], check=True, capture_output=True,
                                text=True).stdout.splitlines()
        wanted = []
        for path in dict.fromkeys(line for line in listed if line.startswith("/") and line != "/."):
            folder, name = os.path.split(path)
            place = os.path.join(os.path.realpath(folder), name)
            if os.path.lexists(place) and not (folder == "/" and name in MERGED):
                wanted.append(place.lstrip("/"))
        take = subprocess.Popen(["tar", "-C", "/", "--no-recursion", "--null", "-T", "-", "-cf", "-"],
                                stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        put = subprocess.Popen(["tar", "-C", self.folder, "-xpf", "-"], stdin=take.stdout)
        take.stdin.write("\0".join(dict.fromkeys(wanted)).encode())
        take.stdin.close()
        take.stdout.close()
        if take.wait() or put.wait():
            raise OSError("files of packages could not be copied")

    def _copy_records(self):
        records = self.folder / "var/lib/dpkg"
        for folder in ("info", "updates", "triggers", "alternatives", "parts"):
            (records / folder).mkdir(parents=True, exist_ok=True)
        kept = set(self.packages)
        stanzas = pathlib.Path("/var/lib/dpkg/status").read_text().split("\n\n")
        (records / "status").write_text("\n\n".join(
            stanza.strip("\n") for stanza in stanzas
            if stanza.strip() and re.search(r"^Package: (\S+)", stanza, re.M).group(1) in kept) + "\n\n")
        for path in pathlib.Path("/var/lib/dpkg/info").iterdir():
            if path.name.rsplit(".", 1)[0].split(":")[0] in kept or path.name == "format":
                shutil.copy2(path, records / "info" / path.name)
        for path in pathlib.Path("/var/lib/dpkg/triggers").iterdir():  # who waits for which files
            lines = path.read_text().splitlines(keepends=True)
            named = [line for line in lines if re.split(r"[:/]", line.split()[-1])[0] in kept]
            (records / "triggers" / path.name).write_text("".join(named))
        (records / "triggers/Unincorp").write_text("")
        (records / "arch").write_text(query("${Architecture}\n", "dpkg"))

    def _link_alternatives(self):
        (self.folder / "etc/alternatives").mkdir(parents=True, exist_ok=True)
        for link in pathlib.Path("/usr/bin").iterdir():
            target = os.readlink(link) if link.is_symlink() else ""
            if target.startswith("/etc/alternatives/") and os.path.lexists(target):
                program = os.readlink(target)
                inside = self.folder / link.relative_to("/")
                if os.path.lexists(self.folder / program.lstrip("/")) and not os.path.lexists(inside):
                    os.symlink(target, inside)
                    os.symlink(program, self.folder / target.lstrip("/"))

    def _make_etc(self):
        for name in ("passwd", "group"):
            shutil.copy(f"/usr/share/base-passwd/{name}.master", self.folder / "etc" / name)
        for name, number in (("null", 3), ("urandom", 9), ("random", 8)):
            (self.folder / "dev").mkdir(exist_ok=True)
            os.mknod(self.folder / "dev" / name, 0o020666, os.makedev(1, number))
            os.chmod(self.folder / "dev" / name, 0o666)
        for name, mode in (("tmp", 0o1777), ("run", 0o755), ("proc", 0o555), ("var/lib", 0o755), ("var/log", 0o755)):
            (self.folder / name).mkdir(parents=True, exist_ok=True)
            (self.folder / name).chmod(mode)
        subprocess.run(["ldconfig", "-r", self.folder], check=True)
