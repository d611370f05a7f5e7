"""The SROS 2 policy allows what the node has, and nothing else; sockets stay on this computer."""

from pathlib import Path
import re
from xml.etree import ElementTree

import domain_coordinator
import pytest
import rclpy
from rclpy.task import Future

from create_oi_ros.node import CreateNode
from create_oi_ros.services import SERVICES
from create_oi_ros.topics import PUBLISHED

ROOT = Path(__file__).parents[1]
POLICY = ElementTree.parse(ROOT / 'config' / 'sros2_policy.xml').getroot()
DOCS = (ROOT / 'docs' / 'security.md').read_text('utf-8')
EVERY_NODE = {'/parameter_events', '/rosout'}


def allowed(enclave: str, what: str) -> set[str]:
    """Return the full names that an enclave may publish, subscribe, reply or request."""
    profile, = POLICY.findall(f".//enclave[@path='{enclave}']/profiles/profile")
    names = set()
    for rule in profile.findall(f"./*[@{what}='ALLOW']"):
        assert set(rule.attrib) == {what}
        for name in rule:
            whole = re.sub('^~', f"/{profile.get('node')}", str(name.text))
            names.add(whole if whole.startswith('/') else f"{profile.get('ns')}{whole}")
    return names


def full(names: list[str]) -> set[str]:
    """Return names as they are without a namespace."""
    return {name if name.startswith('/') else f'/{name}' for name in names}


@pytest.fixture(scope='module')
def node():
    """Return the real node, in a domain of its own."""
    with domain_coordinator.domain_id() as domain:
        rclpy.init(args=[], domain_id=domain)
        made = CreateNode(Future())
        yield made
        made.destroy_node()
        rclpy.shutdown()


@pytest.mark.parametrize(('what', 'ask'), [
    ('publish', 'get_publisher_names_and_types_by_node'),
    ('subscribe', 'get_subscriber_names_and_types_by_node'),
    ('reply', 'get_service_names_and_types_by_node'),
    ('request', 'get_client_names_and_types_by_node'),
])
def test_the_node_may_do_what_it_does_and_no_more(node, what, ask):
    assert allowed('/create', what) == {name for name, _ in getattr(node, ask)('create', '/')}


def test_a_pilot_may_drive_listen_and_ask():
    pilot = '/create/pilot'
    assert allowed(pilot, 'publish') == {'/cmd_vel', *EVERY_NODE}
    assert allowed(pilot, 'subscribe') == full([topic.name for topic in PUBLISHED])
    assert allowed(pilot, 'request') == full([service.name for service in SERVICES])


def test_the_policy_is_installed_where_the_page_looks_for_it():
    assert 'config/sros2_policy.xml' in DOCS
    assert "'config'" in (ROOT / 'setup.py').read_text('utf-8')


def test_every_enclave_has_its_keys_made():
    for enclave in POLICY.iter('enclave'):
        path = enclave.get('path')
        assert f'create_enclave create_keys {path}\n' in DOCS
        assert f'create_permission create_keys {path} $policy' in DOCS
        assert f'--enclave {path}\n' in DOCS
