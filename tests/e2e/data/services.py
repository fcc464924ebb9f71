"""A service; clients that wait, that await, that get a callback, and one that calls and blocks."""

import threading

import rclpy
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger


class Server(Node):
    def __init__(self):
        super().__init__("server")
        self.calls = 0
        self.create_service(SetBool, "switch", self.on_switch)
        self.create_service(Trigger, "fail", lambda request, response: response)

    def on_switch(self, request, response):
        self.calls += 1
        response.success = request.data
        response.message = f"call {self.calls}, {self.calls * 0.5}"
        return response


class Client(Node):
    def __init__(self):
        super().__init__("client", start_parameter_services=False)
        group = ReentrantCallbackGroup()
        self.switch = self.create_client(SetBool, "switch", callback_group=group)
        self.results = []
        self.timer = self.create_timer(0.01, self.on_timer, callback_group=group)
        self.done = threading.Event()

    async def on_timer(self):
        self.timer.cancel()
        self.switch.wait_for_service()
        response = await self.switch.call_async(SetBool.Request(data=True))
        self.results.append(("awaited", response.success, response.message))
        future = self.switch.call_async(SetBool.Request(data=False))
        future.add_done_callback(self.on_done)

    def on_done(self, future):
        response = future.result()
        self.results.append(("callback", response.success, response.message))
        self.done.set()


rclpy.init()
server, client = Server(), Client()
executor = MultiThreadedExecutor(num_threads=4)
executor.add_node(server)
executor.add_node(client)
thread = threading.Thread(target=executor.spin, daemon=True)
thread.start()
assert client.done.wait(20)
response = client.switch.call(SetBool.Request(data=True))
print(*client.results, response, sep="\n")
print(client.create_client(Trigger, "fail").call(Trigger.Request()))
executor.shutdown()
thread.join(20)

late = rclpy.create_node("late")
switch = late.create_client(SetBool, "switch")
future = switch.call_async(SetBool.Request(data=True))
rclpy.spin_until_future_complete(late, future, timeout_sec=0.2)
print(future.done(), switch.srv_name, switch.wait_for_service(timeout_sec=0.1))
rclpy.shutdown()
