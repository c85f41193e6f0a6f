// involute gear like polygon
n=20; m=2; 
function inv(a)= [cos(a)+a*PI/180*sin(a), sin(a)-a*PI/180*cos(a)];
rb=n*m/2*cos(20);
pts=[for(t=[0:n-1]) each concat([for(a=[0:5:30]) let(p=rb*inv(a), r=t*360/n) [p[0]*cos(r)-p[1]*sin(r),p[0]*sin(r)+p[1]*cos(r)]],
 [for(a=[30:-5:0]) let(q=rb*inv(a),p=[q[0],-q[1]], r=t*360/n+9.2) [p[0]*cos(r)-p[1]*sin(r),p[0]*sin(r)+p[1]*cos(r)]])];
difference(){ linear_extrude(8) polygon(pts); translate([0,0,-1]) cylinder(r=4,h=10,$fn=60); for(i=[0:5]) rotate(60*i) translate([11,0,-1]) cylinder(r=3,h=10,$fn=40);}
