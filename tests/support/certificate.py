# SPDX-License-Identifier: Apache-2.0
"""Certificates that sign themselves, of two days, and their keys, as PEM files."""
import subprocess


def make_certificate(cert_file, key_file, name="sea"):
    """For a server of this name on 127.0.0.1."""
    subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", f"/CN={name}", "-addext",
                    "subjectAltName=IP:127.0.0.1", "-keyout", key_file, "-out", cert_file], check=True, capture_output=True)
