#!/usr/bin/python3
"""count_tests.py RESULTS_DIR: counts the test cases in the JUnit files that catkin's tests left, names those that failed, and prints
"N passed, N failed" as the last line. Exit status 1 when one failed or none ran."""
import pathlib
import sys
import xml.etree.ElementTree as ElementTree


def main() -> int:
    passed, failed = 0, []
    for path in sorted(pathlib.Path(sys.argv[1]).rglob('*.xml')):
        try:
            cases = list(ElementTree.parse(path).getroot().iter('testcase'))
        except ElementTree.ParseError as error:
            failed.append(f'{path.name}: not readable ({error})')
            continue
        for case in cases:
            if case.find('failure') is not None or case.find('error') is not None:
                failed.append(f"{path.name}: {case.get('classname')}.{case.get('name')}")
            else:
                passed += 1
    for line in failed:
        print('FAILED', line)
    print(f'{passed} passed, {len(failed)} failed')
    return 0 if passed and not failed else 1


if __name__ == '__main__':
    sys.exit(main())
